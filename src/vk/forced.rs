//! Capabilities by force: what another device has or lacks is tried on the one at hand.
//!
//! A list such as `primitive_id=on, multiview_draws=on, shared_memory=16384, subgroup=none`, in the environment variable
//! [`VARIABLE`] or in [`super::DeviceOptions`]. A feature can be turned on only where the driver offers it, a limit can only
//! be lowered; anything else is an error. Features that are off are not enabled on the device, so that validation reports
//! whoever uses them nevertheless.

use super::capabilities::Capabilities;
use super::error::{Error, Result};
use std::str::FromStr;

/// The environment variable that holds the list.
pub const VARIABLE: &str = "HEMICUBE_FORCE";

/// Entries of a list, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Forced(Vec<(String, String)>);

type Switch = fn(&mut Capabilities) -> &mut bool;
type Limit = fn(&mut Capabilities) -> &mut u32;

/// Features, `on` or `off`.
const SWITCHES: [(&str, Switch); 8] = [
    ("draw_indirect_count", |c| &mut c.draw_indirect_count),
    ("multi_draw_indirect", |c| &mut c.multi_draw_indirect),
    ("primitive_id", |c| &mut c.primitive_id),
    ("multiview_draws", |c| &mut c.multiview_draws),
    ("clips_before_setup", |c| &mut c.clips_before_setup),
    ("logic_op", |c| &mut c.logic_op),
    ("index_uint32", |c| &mut c.index_uint32),
    ("full_subgroups", |c| &mut c.full_subgroups),
];

/// Limits, as numbers.
const LIMITS: [(&str, Limit); 10] = [
    ("views", |c| &mut c.max_views),
    ("shared_memory", |c| &mut c.limits.max_compute_shared_memory_size),
    ("invocations", |c| &mut c.limits.max_compute_work_group_invocations),
    ("storage_range", |c| &mut c.limits.max_storage_buffer_range),
    ("storage_buffers", |c| &mut c.limits.max_per_stage_descriptor_storage_buffers),
    ("texel_elements", |c| &mut c.limits.max_texel_buffer_elements),
    ("image_size", |c| &mut c.limits.max_image_dimension2_d),
    ("image_layers", |c| &mut c.limits.max_image_array_layers),
    ("max_index", |c| &mut c.limits.max_draw_indexed_index_value),
    ("timestamp_bits", |c| &mut c.timestamp_bits),
];

impl Forced {
    /// The list in [`VARIABLE`]; empty where it is not set.
    ///
    /// # Errors
    /// [`Error::Forced`] where an entry is no `name=value`.
    pub fn from_environment() -> Result<Self> {
        std::env::var(VARIABLE).map_or_else(|_| Ok(Self::default()), |list| list.parse())
    }

    /// Whether nothing is forced.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Puts every entry into `has`; `offered` is what the driver says it can do.
    pub(super) fn apply(&self, offered: &Capabilities, has: &mut Capabilities) -> Result<()> {
        self.0.iter().try_for_each(|(name, value)| force(name, value, &mut offered.clone(), has))
    }
}

impl FromStr for Forced {
    type Err = Error;

    fn from_str(list: &str) -> Result<Self> {
        let entries = list.split(',').map(str::trim).filter(|entry| !entry.is_empty());
        let pair = |entry: &str| {
            let (name, value) = entry.split_once('=').ok_or_else(|| refused(entry, "is no name=value".into()))?;
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        };
        entries.map(pair).collect::<Result<_>>().map(Self)
    }
}

fn force(name: &str, value: &str, offered: &mut Capabilities, has: &mut Capabilities) -> Result<()> {
    let entry = format!("{name}={value}");
    if let Some((_, switch)) = SWITCHES.iter().find(|(known, _)| *known == name) {
        let on = match value {
            "on" => true,
            "off" => false,
            _ => return Err(refused(&entry, "must be on or off".into())),
        };
        if on && !*switch(offered) {
            return Err(refused(&entry, "is not offered by the device".into()));
        }
        *switch(has) = on;
    } else if let Some((_, limit)) = LIMITS.iter().find(|(known, _)| *known == name) {
        let most = *limit(offered);
        *limit(has) = number(&entry, value, u64::from(most))? as u32;
    } else if name == "device_memory" {
        has.device_memory = number(&entry, value, u64::MAX)?;
    } else if name == "subgroup" {
        has.subgroup = subgroup(&entry, value, offered)?;
    } else {
        let names = SWITCHES.iter().map(|(name, _)| *name).chain(LIMITS.iter().map(|(name, _)| *name));
        let names: Vec<_> = names.chain(["device_memory", "subgroup"]).collect();
        return Err(refused(&entry, format!("names no capability; there are {}", names.join(", "))));
    }
    Ok(())
}

fn number(entry: &str, value: &str, most: u64) -> Result<u64> {
    match value.parse() {
        Ok(number) if number <= most => Ok(number),
        _ => Err(refused(entry, format!("must be a number up to {most}, which the device has"))),
    }
}

/// `none`, the size that the device has anyway, or another one that its driver lets shaders ask for.
fn subgroup(entry: &str, value: &str, offered: &Capabilities) -> Result<Option<u32>> {
    if value == "none" {
        return Ok(None);
    }
    let [least, most] = offered.subgroup_sizes;
    match value.parse::<u32>() {
        Ok(size) if size.is_power_of_two() && (least..=most).contains(&size) && offered.subgroup.is_some() => {
            Ok(Some(size))
        }
        _ => {
            Err(refused(entry, format!("must be none or a power of two from {least} to {most}, which the device has")))
        }
    }
}

fn refused(entry: &str, reason: String) -> Error {
    Error::Forced { entry: entry.into(), reason }
}
