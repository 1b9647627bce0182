//! Random numbers: the same seed gives the same scene on every machine.

use glam::{Vec3, vec3};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        b ^ (b >> 31)
    }

    /// Evenly between two numbers.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    /// Ten to a power evenly between two.
    pub fn power_of_ten(&mut self, low: f32, high: f32) -> f32 {
        10f32.powf(self.between(low, high))
    }

    /// True in a share of cases.
    pub fn chance(&mut self, share: f32) -> bool {
        self.between(0.0, 1.0) < share
    }

    /// A whole number below `end`.
    pub fn below(&mut self, end: u32) -> u32 {
        (self.next() >> 32) as u32 % end
    }

    /// Each coordinate evenly between two numbers.
    pub fn point(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        vec3(self.between(low.x, high.x), self.between(low.y, high.y), self.between(low.z, high.z))
    }

    /// A unit vector that points down by at least `least`.
    pub fn downwards(&mut self, least: f32) -> Vec3 {
        let (y, turn) = (-self.between(least, 1.0), self.between(0.0, std::f32::consts::TAU));
        let across = (1.0 - y * y).sqrt();
        vec3(across * turn.cos(), y, across * turn.sin())
    }
}
