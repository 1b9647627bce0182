//! Brings together what a view visits together.

use super::{Bounds, CHILDREN};

/// What is brought into an order.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Box around it.
    pub bounds: Bounds,
    /// Distance within which views look at it; none where all do.
    pub reach: Option<f32>,
}

impl Item {
    /// Around nothing.
    const NONE: Self = Self { bounds: Bounds::EMPTY, reach: Some(0.0) };

    fn joined(self, other: Self) -> Self {
        let reach = self.reach.zip(other.reach).map(|(a, b)| a.max(b));
        Self { bounds: self.bounds.joined(other.bounds), reach }
    }

    fn within_reach(&self) -> f32 {
        self.reach.unwrap_or(f32::MAX)
    }
}

/// Orders `items` so that each node of a tree, and what it holds, comes together: halves of halves, cut where nodes are full.
pub fn sorted(items: &[Item]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..items.len() as u32).collect();
    let whole = Bounds::around(items.iter().map(|i| i.bounds));
    Sort { items, whole }.sort(&mut order);
    order
}

struct Sort<'a> {
    items: &'a [Item],
    whole: Bounds,
}

impl Sort<'_> {
    fn sort(&self, order: &mut [u32]) {
        if order.len() <= CHILDREN {
            // What is drawn side by side: of like size, it takes like time.
            let area = |i: &u32| self.items[*i as usize].bounds.area();
            order.sort_by(|a, b| area(b).total_cmp(&area(a)));
            return;
        }
        let node = CHILDREN.pow((order.len() - 1).ilog(CHILDREN));
        let middle = order.len().div_ceil(node).div_ceil(2) * node;
        self.halve(order, middle);
        let (front, back) = order.split_at_mut(middle);
        rayon::join(|| self.sort(front), || self.sort(back));
    }

    /// Brings `middle` of the items to the front, so that views visit few of both halves (surface area heuristic, Goldsmith
    /// and Salmon 1987): halves along an axis, or the larger ones by themselves, or those that views look at from afar.
    fn halve(&self, order: &mut [u32], middle: usize) {
        let candidate = |by: usize| {
            let mut half = order.to_vec();
            half.select_nth_unstable_by(middle, |a, b| self.key(by, *a).total_cmp(&self.key(by, *b)));
            let cost = |part: &[u32]| {
                let all = part.iter().map(|i| self.items[*i as usize]).fold(Item::NONE, Item::joined);
                self.visits(all) * part.len() as f32
            };
            let (front, back) = half.split_at(middle);
            (cost(front) + cost(back), half)
        };
        let has_reach = order.iter().any(|i| self.items[*i as usize].reach.is_some());
        let candidates = if has_reach { 0..6 } else { 0..4 };
        let best = candidates.map(candidate).min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are several candidates");
        order.copy_from_slice(&best.1);
    }

    fn key(&self, by: usize, i: u32) -> f32 {
        let item = &self.items[i as usize];
        match by {
            0..3 => item.bounds.low[by] + item.bounds.high[by],
            3 => -item.bounds.size().max_element(),
            4 => item.within_reach(),
            _ => -item.within_reach(),
        }
    }

    /// How many views look at an item, in parts of something: those that are near enough, with their eyes anywhere in the
    /// scene, and which it reaches into, the more the larger it looks. Without a reach the rays that meet its box.
    fn visits(&self, item: Item) -> f32 {
        let Some(reach) = item.reach else { return item.bounds.area() };
        let (low, high) = (self.whole.low.truncate(), self.whole.high.truncate());
        let from = (item.bounds.low.truncate() - reach).max(low);
        let to = (item.bounds.high.truncate() + reach).min(high);
        let (near, wide) = ((to - from).element_product(), item.bounds.size().length());
        let away = 0.5 * (reach + wide).min(0.5 * (high - low).length());
        if away > 0.0 { near * (1.0 + wide / away).powi(2) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn squares(side: u32) -> impl Iterator<Item = Bounds> {
        (0..side * side).map(move |i| {
            let low = Vec3::new((i % side) as f32, 0.0, (i / side) as f32);
            Bounds::of(&[low, low + Vec3::X + Vec3::Z])
        })
    }

    fn is_an_order(mut order: Vec<u32>, count: usize) -> bool {
        order.sort_unstable();
        order.into_iter().eq(0..count as u32)
    }

    /// A sheet of small squares and one large triangle over all of it.
    #[test]
    fn every_triangle_is_in_one_compact_cluster() {
        let all = Bounds::of(&[Vec3::ZERO, Vec3::splat(64.0)]);
        let items: Vec<_> = squares(64).chain([all]).map(|bounds| Item { bounds, reach: None }).collect();
        let order = sorted(&items);
        let around = |c: &[u32]| Bounds::around(c.iter().map(|i| items[*i as usize].bounds));
        let areas: Vec<f32> = order.chunks(64).map(|c| around(c).area()).collect();
        // 64 squares cover 64 at least; only the cluster of the large one may be large.
        let large = areas.iter().filter(|area| **area > 128.0).count();
        assert!(large <= 1, "{large} clusters are large: {areas:?}");
        assert!(is_an_order(order, items.len()));
    }

    /// Of the same place, what is looked at from nearby alone is apart from what is looked at from afar.
    #[test]
    fn what_is_near_is_apart_from_what_is_far() {
        let far = |i: usize| i.is_multiple_of(2);
        let item = |(i, bounds)| Item { bounds, reach: Some(if far(i) { 100.0 } else { 0.01 }) };
        let items: Vec<_> = squares(32).enumerate().map(item).collect();
        let order = sorted(&items);
        let is_mixed = |c: &&[u32]| c.iter().any(|i| far(*i as usize)) && c.iter().any(|i| !far(*i as usize));
        let mixed = order.chunks(CHILDREN).filter(is_mixed).count();
        assert!(mixed == 0, "{mixed} nodes hold both");
        assert!(is_an_order(order, items.len()));
    }
}
