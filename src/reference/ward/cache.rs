//! The records and the interpolation between them.

use super::hemisphere::Measurement;
use super::octree::Octree;
use super::{Gradients, Settings, Weight};
use crate::math::ward;
use glam::DVec3;

/// A record: a place, how far it is valid, and what it measured.
#[derive(Debug, Clone, Copy)]
pub struct Record {
    /// Relative to the scene's origin.
    pub position: DVec3,
    /// Unit shading normal.
    pub normal: DVec3,
    /// What the hemisphere's rays found.
    pub measured: Measurement,
    /// Harmonic mean distance, limited by the gradient and by neighbours; scene units.
    pub distance: f64,
    /// Radius of the zone of influence, a·R within its limits in pixels; scene units.
    pub radius: f64,
    /// Index of the pixel that asked for it.
    pub pixel: u32,
    /// Width of that pixel at the record, scene units.
    footprint: f64,
}

/// Records in an octree.
pub struct Cache {
    /// In the order of insertion.
    pub records: Vec<Record>,
    settings: Settings,
    octree: Octree,
}

impl Cache {
    /// An empty cache for places within the given cube.
    pub fn new(settings: Settings, center: DVec3, half: f64) -> Self {
        Self { records: vec![], settings, octree: Octree::new(center, half) }
    }

    /// Adds a measurement.
    pub fn insert(&mut self, position: DVec3, normal: DVec3, measured: Measurement, pixel: u32, footprint: f64) {
        let mut distance = 1.0 / measured.inverse_distance;
        if self.settings.gradient_limit {
            distance = distance.min(gradient_limit(&measured));
        }
        if self.settings.neighbour_clamping {
            distance = self.clamp_neighbours(position, distance);
        }
        let radius = self.zone(distance, footprint);
        self.octree.insert(self.records.len() as u32, position, radius);
        self.records.push(Record { position, normal, measured, distance, radius, pixel, footprint });
    }

    /// Limits a new record's R by those around it, and theirs by it.
    fn clamp_neighbours(&mut self, position: DVec3, mut distance: f64) -> f64 {
        let mut around = vec![];
        self.octree.around(position, |i| around.push(i as usize));
        around.retain(|&i| self.records[i].position.distance(position) < self.records[i].radius);
        for &i in &around {
            let record = &self.records[i];
            distance = ward::clamp_neighbours(distance, record.distance, record.position.distance(position)).0;
        }
        for i in around {
            let record = &self.records[i];
            let limited = ward::clamp_neighbours(distance, record.distance, record.position.distance(position)).1;
            // The octree's node stays: a zone only shrinks.
            let radius = self.zone(limited, record.footprint);
            (self.records[i].distance, self.records[i].radius) = (limited, radius);
        }
        distance
    }

    fn zone(&self, distance: f64, footprint: f64) -> f64 {
        let Settings { accuracy, min_radius, max_radius, .. } = self.settings;
        (accuracy * distance).clamp(min_radius * footprint, max_radius * footprint)
    }

    /// Weight of a record at a place; 0 if it is not to be used there.
    fn weight(&self, record: &Record, position: DVec3, normal: DVec3) -> f64 {
        let offset = position - record.position;
        let (d, cos) = (offset.length(), normal.dot(record.normal));
        if d >= record.radius || cos <= 0.0 {
            return 0.0;
        }
        let a = self.settings.accuracy;
        let reach = record.radius / a;
        if ward::in_front(offset, normal, record.normal, reach) {
            return 0.0;
        }
        match self.settings.weight {
            Weight::Ward => ward::used(d, reach, cos, a),
            Weight::Bounded => ward::bounded(d, record.radius, cos, 1.0 - a * a),
        }
    }

    /// Whether some record is valid here.
    pub fn covers(&self, position: DVec3, normal: DVec3) -> bool {
        let mut covered = false;
        self.octree.around(position, |i| {
            covered = covered || self.weight(&self.records[i as usize], position, normal) > 0.0;
        });
        covered
    }

    /// Interpolated irradiance (W·m⁻²) and the number of records it came from; `None` where no record is valid.
    pub fn irradiance(&self, position: DVec3, normal: DVec3) -> Option<(DVec3, u32)> {
        let (mut sum, mut weights, mut count) = (DVec3::ZERO, 0.0, 0);
        self.octree.around(position, |i| {
            let record = &self.records[i as usize];
            let weight = self.weight(record, position, normal);
            if weight > 0.0 {
                sum += self.extrapolate(record, position, normal) * weight;
                weights += weight;
                count += 1;
            }
        });
        (count > 0).then(|| ((sum / weights).max(DVec3::ZERO), count))
    }

    /// First-order extrapolation of a record (Ward and Heckbert 1992).
    fn extrapolate(&self, record: &Record, position: DVec3, normal: DVec3) -> DVec3 {
        let m = &record.measured;
        let mut e = m.irradiance;
        if self.settings.gradients.rotation() {
            let turn = record.normal.cross(normal);
            e += DVec3::from(m.rotation.map(|g| turn.dot(g)));
        }
        if self.settings.gradients.translation() {
            // Where the smallest radius makes a record reach farther than it should, its slope is made gentler by as much
            // (R / R_min; Křivánek and Gautron 2009): it was not measured for such distances.
            let gentler = (self.settings.accuracy * record.distance / record.radius).min(1.0);
            let offset = (position - record.position) * gentler;
            e += DVec3::from(m.translation.map(|g| offset.dot(g)));
        }
        e
    }
}

/// R ≤ E / ‖∇_t E‖: farther, the linear extrapolation reaches zero.
fn gradient_limit(m: &Measurement) -> f64 {
    let gradient = m.translation.iter().sum::<DVec3>().length();
    if gradient > 0.0 { m.irradiance.element_sum() / gradient } else { f64::INFINITY }
}

impl Gradients {
    fn rotation(self) -> bool {
        matches!(self, Self::Rotation | Self::Both)
    }

    fn translation(self) -> bool {
        matches!(self, Self::Translation | Self::Both)
    }
}
