//! Passes in order: each is named, labelled, timed and ordered after the one before it by the same call.

use super::barrier;
use super::commands::Commands;
use super::device::Device;
use super::error::{Error, Result};
use super::timer::{Span, Timer};
use std::sync::Arc;

/// One run of one pass. All spans count from [`Device::opened`].
#[derive(Clone, Copy, Debug)]
pub struct PassTime {
    /// Name of the pass: its module, its shader folder and its row in the report.
    pub name: &'static str,
    /// On the GPU; `None` on a queue without timestamps.
    pub gpu: Option<Span>,
    /// Recording on the CPU.
    pub cpu: Span,
}

/// Records submissions and keeps the time of every pass in them.
pub struct Recorder {
    device: Arc<Device>,
    timer: Timer,
    open: Vec<(&'static str, Span)>,
    /// Every pass that ran, in order.
    pub passes: Vec<PassTime>,
    /// Every submission: first to last timestamp.
    pub submissions: Vec<Span>,
}

impl Recorder {
    /// Nothing recorded yet.
    pub fn new(device: &Arc<Device>) -> Self {
        Self {
            device: device.clone(),
            timer: Timer::new(device),
            open: Vec::new(),
            passes: Vec::new(),
            submissions: Vec::new(),
        }
    }

    /// Records a submission with `record`, runs it and waits. After an error the recorder goes on as if it had not been.
    ///
    /// # Errors
    /// Those of `record`; [`Error::DeviceLost`] and [`Error::TimedOut`] name the pass.
    pub fn submit(&mut self, record: impl FnOnce(&mut Recording<'_>) -> Result<()>) -> Result<()> {
        let done = self.try_submit(record);
        if done.is_err() {
            self.timer.forget();
            self.open.clear();
        }
        done
    }

    fn try_submit(&mut self, record: impl FnOnce(&mut Recording<'_>) -> Result<()>) -> Result<()> {
        let commands = Commands::begin(&self.device)?;
        let mut recording = Recording { commands, recorder: self };
        recording.stamp()?;
        record(&mut recording)?;
        recording.stamp()?;
        let Recording { commands, .. } = recording;
        self.timer.submitted();
        commands.run("").map_err(|error| self.named(error))?;
        self.collect()
    }

    /// The error with the pass that was running, as far as its timestamps show, else with all passes of the submission.
    fn named(&self, error: Error) -> Error {
        let stamps = self.timer.written();
        let running = self.open.iter().enumerate().find(|(index, _)| stamps.get(2 + 2 * index) == Some(&false));
        let content = match running {
            Some((_, (name, _))) => format!("the pass \"{name}\""),
            None => {
                let names: Vec<_> = self.open.iter().map(|(name, _)| *name).collect();
                format!("the passes {}", names.join(", "))
            }
        };
        match error {
            Error::DeviceLost { .. } => Error::DeviceLost { content },
            Error::TimedOut { seconds, .. } => Error::TimedOut { content, seconds },
            other => other,
        }
    }

    fn collect(&mut self) -> Result<()> {
        let stamps = if self.timer.available() { self.timer.read()? } else { Vec::new() };
        if let (Some(begin_ms), Some(end_ms)) = (stamps.first(), stamps.last()) {
            self.submissions.push(Span { begin_ms: *begin_ms, end_ms: *end_ms });
        }
        for (index, (name, cpu)) in self.open.drain(..).enumerate() {
            let gpu = stamps.get(1 + 2 * index..3 + 2 * index).map(|pair| Span { begin_ms: pair[0], end_ms: pair[1] });
            self.passes.push(PassTime { name, gpu, cpu });
        }
        Ok(())
    }
}

/// A submission being recorded.
pub struct Recording<'a> {
    /// Its command buffer.
    pub commands: Commands,
    recorder: &'a mut Recorder,
}

impl Recording<'_> {
    /// Records one pass: after all before it, between two timestamps, under a debug label, all named `name`.
    ///
    /// lavapipe writes a timestamp when the rasteriser gets there, so that only full barriers on both sides make it true.
    pub fn pass(&mut self, name: &'static str, record: impl FnOnce(&Commands) -> Result<()>) -> Result<()> {
        let opened = self.recorder.device.opened;
        let begin = opened.elapsed();
        self.stamp()?;
        self.commands.device.begin_label(self.commands.raw, name);
        record(&self.commands)?;
        self.commands.device.end_label(self.commands.raw);
        self.stamp()?;
        let end = opened.elapsed();
        let cpu = Span { begin_ms: begin.as_secs_f64() * 1e3, end_ms: end.as_secs_f64() * 1e3 };
        self.recorder.open.push((name, cpu));
        Ok(())
    }

    fn stamp(&mut self) -> Result<()> {
        barrier::full(&self.commands);
        if self.recorder.timer.available() {
            self.recorder.timer.stamp(&self.commands)?;
            barrier::full(&self.commands);
        }
        Ok(())
    }
}
