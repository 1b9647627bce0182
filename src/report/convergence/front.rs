//! Which points are worth having: those that nothing beats in both time and error.

use super::point::{Point, Time};

/// Indices of the points of (time, error) that no other is both faster and better than, by rising time.
///
/// Of equal points the first stays; points that are no numbers never do.
pub fn pareto(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    order.sort_by(|&a, &b| {
        points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)).then(a.cmp(&b))
    });
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < best;
        best = best.min(points[i].1);
        better
    });
    order
}

/// A chart's place of each point: index, time and error. Points without a time or an error above 0 have none.
pub fn places(points: &[Point], time: Time, error: &str) -> Vec<(usize, f64, f64)> {
    let place =
        |(i, point): (usize, &Point)| Some((i, point.seconds(time)?, point.number(error).filter(|e| *e > 0.0)?));
    points.iter().enumerate().filter_map(place).collect()
}

/// The points on the front of all, as indices into `points`.
pub fn front(points: &[Point], time: Time, error: &str) -> Vec<usize> {
    let places = places(points, time, error);
    let plain: Vec<(f64, f64)> = places.iter().map(|&(_, t, e)| (t, e)).collect();
    pareto(&plain).into_iter().map(|k| places[k].0).collect()
}

/// Time at which a front reaches an error, interpolated in logarithms between its points; none where it does not get
/// there. A front that starts below the error gives the time of its first point, which is then an upper bound.
pub fn time_to_reach(front: &[(f64, f64)], error: f64) -> Option<f64> {
    let after = front.iter().position(|&(_, e)| e <= error)?;
    let (t1, e1) = front[after];
    let Some(&(t0, e0)) = after.checked_sub(1).map(|before| &front[before]) else { return Some(t1) };
    let part = (e0 / error).ln() / (e0 / e1).ln();
    Some(t0 * (t1 / t0).powf(part))
}

#[cfg(test)]
mod tests {
    use super::super::point::tests::sample;
    use super::*;

    #[test]
    fn only_unbeaten_points_are_on_the_front() {
        // (2, 0.5) beats (3, 0.6); (5, 0.5) is slower and no better; (1, 1) is the fastest.
        let points =
            [(3.0, 0.6), (2.0, 0.5), (1.0, 1.0), (5.0, 0.5), (8.0, 0.1), (f64::NAN, 0.0), (1.0, 2.0), (2.0, 0.5)];
        assert_eq!(pareto(&points), [2, 1, 4]);
        assert!(pareto(&[]).is_empty());
    }

    #[test]
    fn every_point_off_the_front_is_beaten_and_none_on_it_is() {
        let value = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65536.0;
        let points: Vec<(f64, f64)> = (0..200).map(|i| (value(2 * i), value(2 * i + 1))).collect();
        let on = pareto(&points);
        for (i, p) in points.iter().enumerate() {
            let beaten = points.iter().any(|q| q.0 <= p.0 && q.1 <= p.1 && q != p);
            assert_eq!(on.contains(&i), !beaten, "{p:?}");
        }
    }

    #[test]
    fn points_without_time_are_left_out() {
        let mut points = vec![sample("a", 0.3, 1.0, 0.2), sample("b", 0.3, 1.0, 0.1), sample("c", 0.3, 0.0, 0.05)];
        points[1].row.remove("indirect_cpu_s");
        assert_eq!(front(&points, Time::Cpu, "mae"), [0]);
        assert_eq!(front(&points, Time::Wall, "mae"), [1]);
    }

    #[test]
    fn times_are_interpolated_in_logarithms() {
        let front = [(1.0, 0.4), (4.0, 0.1)];
        assert!((time_to_reach(&front, 0.2).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(time_to_reach(&front, 0.05), None);
        assert_eq!(time_to_reach(&front, 0.5), Some(1.0));
        assert_eq!(time_to_reach(&front, 0.1), Some(4.0));
    }
}
