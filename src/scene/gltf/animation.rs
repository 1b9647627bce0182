//! Animations: the values that their channels give nodes at one moment.

use super::Notes;
use super::accessor::Reader;
use super::buffers::Buffers;
use super::document::{Document, item};
use super::error::{Fault, Result, Within, label, quote};
use crate::scene::load::Pose;
use glam::DQuat;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// What an animation says of a node; `None` where the node's own value counts.
#[derive(Debug, Default)]
pub struct NodePose {
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub weights: Option<Vec<f64>>,
}

/// What is said of each animated node.
pub type Poses = BTreeMap<usize, NodePose>;

#[derive(Deserialize)]
struct Animation {
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Channel {
    sampler: usize,
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    node: Option<usize>,
    path: String,
    #[serde(default)]
    extensions: Value,
}

#[derive(Deserialize)]
struct Sampler {
    input: usize,
    output: usize,
    #[serde(default)]
    interpolation: Interpolation,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Interpolation {
    Step,
    #[default]
    Linear,
    CubicSpline,
}

/// Names of the file's animations; empty where one has none.
pub fn names(document: &Document) -> Vec<String> {
    let name = |a: &Value| a.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
    document.animations.iter().map(name).collect()
}

/// Length of each animation in seconds: its last key's time, 0 where it cannot be read.
pub fn lengths(document: &Document, buffers: &Buffers<'_>) -> Vec<f64> {
    let end = |input: usize| {
        let times = Reader::open(document, buffers, input, 1..=1).ok()?;
        (times.count > 0).then(|| f64::from(times.get::<1>(times.count - 1)[0])).filter(|t| t.is_finite())
    };
    let length = |value: &Value| {
        let samplers = Animation::deserialize(value).map(|a| a.samplers).unwrap_or_default();
        samplers.iter().filter_map(|s| end(s.input)).fold(0.0, f64::max)
    };
    document.animations.iter().map(length).collect()
}

/// What the chosen animation gives nodes at the chosen moment; nothing in the rest pose.
pub fn poses(document: &Document, buffers: &Buffers<'_>, pose: &Pose, notes: &mut Notes) -> Result<Poses> {
    let mut poses = Poses::new();
    if pose.is_rest() {
        return Ok(poses);
    }
    let index = choose(document, pose.animation.as_deref())?;
    let name = names(document).swap_remove(index);
    let at = || label("animation", index, Some(&name));
    let animation = Animation::deserialize(&document.animations[index]).map_err(Fault::invalid).within(at)?;
    let time = pose.seconds.unwrap_or(0.0);
    for (number, channel) in animation.channels.iter().enumerate() {
        let channel = Applied { document, buffers, animation: &animation, channel, time };
        channel.apply(&mut poses, notes).within(|| format!("channel {number}")).within(at)?;
    }
    Ok(poses)
}

/// The animation by its name first and then by its index; the file's first without a wish.
fn choose(document: &Document, wanted: Option<&str>) -> Result<usize> {
    let names = names(document);
    if names.is_empty() {
        return Err(Fault::invalid("has no animations; leave --time and --animation out"));
    }
    let Some(wanted) = wanted else { return Ok(0) };
    let by_index = || wanted.parse().ok().filter(|i| *i < names.len());
    names.iter().position(|n| n == wanted).or_else(by_index).ok_or_else(|| {
        let list: Vec<String> = names.iter().enumerate().map(|(i, n)| format!("{i} \"{}\"", quote(n))).collect();
        Fault::invalid(format!("no animation \"{}\"; there are {}", quote(wanted), list.join(", ")))
    })
}

/// A channel at a moment.
struct Applied<'a, 'b> {
    document: &'a Document,
    buffers: &'a Buffers<'b>,
    animation: &'a Animation,
    channel: &'a Channel,
    time: f64,
}

impl Applied<'_, '_> {
    fn apply(&self, poses: &mut Poses, notes: &mut Notes) -> Result<()> {
        let Some((node, path)) = self.target(notes) else { return Ok(()) };
        item(&self.document.nodes, "node", node)?;
        let pose = poses.entry(node).or_default();
        match path {
            "translation" => pose.translation = Some(fixed(&self.value(3)?)),
            "scale" => pose.scale = Some(fixed(&self.value(3)?)),
            "rotation" => pose.rotation = Some(fixed(&self.value(4)?)),
            "weights" => pose.weights = Some(self.value(1)?),
            other => notes.add(format!("animation of {} is left out", quote(other))),
        }
        Ok(())
    }

    /// The node and its property; `None` for what is not applied, which is noted.
    fn target(&self, notes: &mut Notes) -> Option<(usize, &str)> {
        let target = &self.channel.target;
        if target.path != "pointer" {
            return target.node.map(|node| (node, target.path.as_str()));
        }
        let pointer = target.extensions.pointer("/KHR_animation_pointer/pointer").and_then(Value::as_str);
        let pointer = pointer.unwrap_or_default();
        let node = pointer.strip_prefix("/nodes/").and_then(|rest| rest.split_once('/'));
        let node = node.and_then(|(index, path)| Some((index.parse().ok()?, path)));
        let known = node.filter(|(_, path)| ["translation", "rotation", "scale", "weights"].contains(path));
        notes.add_if(
            &format!("KHR_animation_pointer: the animation of {} is left out", quote(pointer)),
            known.is_none(),
        );
        known
    }

    /// The sampler's value: `components` numbers, or a morph weight a target where that is 1.
    fn value(&self, components: usize) -> Result<Vec<f64>> {
        let sampler = item(&self.animation.samplers, "sampler", self.channel.sampler)?;
        let open = |accessor, components: usize, name: &str| {
            let reader = Reader::open(self.document, self.buffers, accessor, components..=components);
            reader.within(|| format!("accessor {accessor} {name}"))
        };
        let (times, values) = (open(sampler.input, 1, "input")?, open(sampler.output, components, "output")?);
        let curve = Curve::new(times, values, sampler.interpolation, components)?;
        let value = curve.at(self.time);
        match value.iter().all(|x| x.is_finite()) {
            true => Ok(value),
            false => Err(Fault::invalid(format!("its value at {} s is not finite", self.time))),
        }
    }
}

fn fixed<const N: usize>(value: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| value.get(i).copied().unwrap_or(0.0))
}

/// Keys and the way between them (glTF 2.0 §3.11 and appendix C).
struct Curve<'a> {
    times: Reader<'a>,
    values: Reader<'a>,
    interpolation: Interpolation,
    /// Components of an element: 3 or 4, or 1 where a value is several elements.
    components: usize,
    /// Elements of a value: 1, or one a morph target.
    elements: usize,
}

impl<'a> Curve<'a> {
    fn new(times: Reader<'a>, values: Reader<'a>, interpolation: Interpolation, components: usize) -> Result<Self> {
        let slots = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let keys = times.count.saturating_mul(slots);
        let elements = if components == 1 && keys > 0 { values.count / keys } else { 1 };
        if keys == 0 || elements == 0 || values.count != keys.saturating_mul(elements) {
            let what = format!("{} keys do not fit {} values", times.count, values.count);
            return Err(Fault::invalid(what));
        }
        Ok(Self { times, values, interpolation, components, elements })
    }

    fn time(&self, key: usize) -> f64 {
        f64::from(self.times.get::<1>(key)[0])
    }

    /// A value of a key; slots are the incoming tangent, the value and the outgoing tangent of a spline.
    fn key(&self, key: usize, slot: usize) -> Vec<f64> {
        let first = match self.interpolation {
            Interpolation::CubicSpline => (3 * key + slot) * self.elements,
            _ => key * self.elements,
        };
        let element = |e| self.values.get::<4>(first + e).into_iter().take(self.components).map(f64::from);
        (0..self.elements).flat_map(element).collect()
    }

    /// The value at `time`; before the first key that key's, after the last that one's.
    fn at(&self, time: f64) -> Vec<f64> {
        let (mut low, mut high) = (0, self.times.count);
        while low < high {
            let middle = low.midpoint(high);
            if self.time(middle) <= time { low = middle + 1 } else { high = middle }
        }
        let last = low.saturating_sub(1);
        if low == 0 || last + 1 == self.times.count {
            return self.unit(self.key(last, 1));
        }
        let step = self.time(last + 1) - self.time(last);
        let t = if step > 0.0 { (time - self.time(last)) / step } else { 0.0 };
        self.between(last, t, step)
    }

    /// The value at the share `t` of the `step` seconds from a key to the next.
    fn between(&self, key: usize, t: f64, step: f64) -> Vec<f64> {
        let (from, to) = (self.key(key, 1), self.key(key + 1, 1));
        let mix = |weights: [f64; 4], terms: [&[f64]; 4]| -> Vec<f64> {
            (0..from.len()).map(|i| weights.iter().zip(terms).map(|(w, term)| w * term[i]).sum()).collect()
        };
        match self.interpolation {
            Interpolation::Step => self.unit(from),
            Interpolation::Linear if self.components == 4 => {
                let [from, to] = [from, to].map(|q| DQuat::from_array(fixed(&self.unit(q))));
                from.slerp(to, t).to_array().to_vec()
            }
            Interpolation::Linear => mix([1.0 - t, t, 0.0, 0.0], [&from, &to, &from, &to]),
            Interpolation::CubicSpline => {
                let (leaving, arriving) = (self.key(key, 2), self.key(key + 1, 0));
                let (t2, t3) = (t * t, t * t * t);
                let weights =
                    [2.0 * t3 - 3.0 * t2 + 1.0, step * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, step * (t3 - t2)];
                self.unit(mix(weights, [&from, &leaving, &to, &arriving]))
            }
        }
    }

    /// Quaternions with length 1; other values, and quaternions without a length, as they are.
    fn unit(&self, value: Vec<f64>) -> Vec<f64> {
        let length = value.iter().map(|x| x * x).sum::<f64>().sqrt();
        let turns = self.components == 4 && length > 0.0 && length.is_finite();
        if turns { value.into_iter().map(|x| x / length).collect() } else { value }
    }
}
