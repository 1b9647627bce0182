//! Boxes, as `glsl/capture_compute` reads them.

use crate::math::levels::Bound;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// An axis-aligned box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Bounds {
    /// Lowest corner.
    pub low: Vec4,
    /// Highest corner.
    pub high: Vec4,
}

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    /// Around points.
    pub fn of(points: &[Vec3]) -> Self {
        points.iter().map(|p| p.extend(0.0)).fold(Self::EMPTY, |b, p| b.with(p, p))
    }

    /// Of corners as the device has them.
    pub fn of_corners(corners: &[Vec4]) -> Self {
        corners.iter().fold(Self::EMPTY, |b, p| b.with(*p, *p))
    }

    /// Around several.
    pub fn around(boxes: impl IntoIterator<Item = Self>) -> Self {
        boxes.into_iter().fold(Self::EMPTY, Self::joined)
    }

    /// Around both.
    pub fn joined(self, other: Self) -> Self {
        self.with(other.low, other.high)
    }

    fn with(self, low: Vec4, high: Vec4) -> Self {
        Self { low: self.low.min(low), high: self.high.max(high) }
    }

    /// From the lowest corner to the highest.
    pub fn size(self) -> Vec3 {
        (self.high - self.low).truncate()
    }

    /// Half its surface area.
    pub fn area(self) -> f32 {
        let d = self.size();
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

impl From<Bound> for Bounds {
    fn from(b: Bound) -> Self {
        Self { low: b.low.extend(0.0), high: b.high.extend(0.0) }
    }
}
