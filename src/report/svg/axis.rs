//! Logarithmic axes.

/// A logarithmic axis between two places.
pub struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Holds all values above 0 with some room around them, a decade at least.
    pub fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs = values.filter(|v| v.is_finite() && *v > 0.0).map(f64::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 1.0) };
        let room = 0.06 * (high - low) + 0.03_f64.max(0.5 * (0.8 - (high - low)));
        Self { low: low - room, high: high + room, from, to }
    }

    /// Where a value stands.
    pub fn place(&self, value: f64) -> f64 {
        self.from + (self.to - self.from) * (value.log10() - self.low) / (self.high - self.low)
    }

    /// Values of 1, 2 and 5 times powers of ten within the axis; 1 alone where that would be many, more where few.
    pub fn ticks(&self) -> Vec<f64> {
        let steps: &[f64] = match self.high - self.low {
            long if long > 3.2 => &[1.0],
            short if short < 1.2 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
            _ => &[1.0, 2.0, 5.0],
        };
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
        all.filter(|value| (self.low..=self.high).contains(&value.log10())).collect()
    }
}

/// A tick's value with the digits that it needs.
pub fn number(value: f64) -> String {
    let digits = (-value.log10().floor()).clamp(0.0, 9.0) as usize;
    // One digit more for 1.5 times a power of ten.
    let digits = if (value * 10f64.powi(digits as i32)).fract().abs() > 0.3 { digits + 1 } else { digits };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_stand_within_the_plot() {
        for (low, high) in [(0.01, 10.0), (3.0, 3.0), (1e-9, 1e9)] {
            let axis = Axis::over([low, high].into_iter(), 100.0, 500.0);
            assert!((100.0..=500.0).contains(&axis.place(low)) && (100.0..=500.0).contains(&axis.place(high)));
            assert!((2..24).contains(&axis.ticks().len()), "{:?}", axis.ticks());
        }
        assert_eq!(
            [0.02, 0.5, 20.0, 1.0, 0.015, 1.5, 15.0].map(number),
            ["0.02", "0.5", "20", "1", "0.015", "1.5", "15"]
        );
    }
}
