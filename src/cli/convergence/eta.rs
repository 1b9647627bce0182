//! Time that is left.

use super::task::Task;
use std::time::Duration;

/// Time that is left, by what points of the same method took for their work.
pub struct Eta<'a> {
    tasks: &'a [Task],
    spent: Vec<Duration>,
}

impl<'a> Eta<'a> {
    /// Nothing is done yet.
    pub fn new(tasks: &'a [Task]) -> Self {
        Self { tasks, spent: Vec::new() }
    }

    /// Notes the time of the task of that index; they are done in order.
    pub fn done(&mut self, index: usize, time: Duration) {
        debug_assert_eq!(index, self.spent.len());
        self.spent.push(time);
    }

    /// What is left, for people.
    pub fn words(&self) -> String {
        let seconds = self.seconds();
        match self.tasks.len() - self.spent.len() {
            0 => String::new(),
            left if seconds < 100.0 => format!("; {left} left, about {seconds:.0} s"),
            left => format!("; {left} left, about {:.0} min", seconds / 60.0),
        }
    }

    fn seconds(&self) -> f64 {
        let rate = |method: Option<&str>| {
            let own = || self.tasks.iter().zip(&self.spent).filter(|(t, _)| method.is_none_or(|m| t.method() == m));
            let (work, time) = own().fold((0.0, 0.0), |(w, s), (task, time)| {
                (w + if method.is_some() { task.work() } else { 1.0 }, s + time.as_secs_f64())
            });
            (work > 0.0).then(|| time / work)
        };
        let left = self.tasks.iter().skip(self.spent.len());
        left.map(|task| match rate(Some(task.method())) {
            Some(rate) => rate * task.work(),
            None => rate(None).unwrap_or(0.0),
        })
        .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_the_work_of_the_same_method() {
        let tasks = [4, 16, 64].map(|spp| Task::Path { spp });
        let mut eta = Eta::new(&tasks);
        eta.done(0, Duration::from_secs(2));
        assert_eq!((eta.seconds(), eta.words().as_str()), (40.0, "; 2 left, about 40 s"));
        eta.done(1, Duration::from_secs(8));
        eta.done(2, Duration::from_secs(32));
        assert_eq!(eta.words(), "");
    }
}
