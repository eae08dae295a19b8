//! Painting from far to near.

use super::camera::{Camera, dot};
use super::stage::Spot;
use crate::report::chart::svg::Canvas;

/// More areas than this are ordered by their mean depth only.
const FACES: usize = 64;

/// Something painted at once.
#[derive(Clone, Debug)]
pub(super) struct Item {
    /// Class of the colour.
    pub group: String,
    /// Class of the path.
    pub class: &'static str,
    /// Width of its line; none for paths whose class knows it.
    pub width: Option<f64>,
    pub d: String,
    pub tip: Option<String>,
    /// A line in the colour of the background that is painted before: its width and its path.
    pub halo: Option<(f64, String)>,
    /// A point in its middle.
    pub middle: Spot,
    /// Depth by which it is ordered.
    pub depth: f64,
}

/// A tinted area.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub group: String,
    pub class: &'static str,
    pub d: String,
    pub corners: Vec<Spot>,
}

impl Face {
    fn depth(&self) -> f64 {
        self.corners.iter().map(|c| c.depth).sum::<f64>() / self.corners.len().max(1) as f64
    }

    /// A point and a normal of its plane (Newell's method, which tolerates corners beside the plane).
    fn plane(&self) -> ([f64; 3], [f64; 3]) {
        let (mut middle, mut normal) = ([0.0; 3], [0.0; 3]);
        for (a, b) in self.corners.iter().zip(self.corners.iter().cycle().skip(1)) {
            let (a, b) = (a.at, b.at);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                normal[i] += (a[j] - b[j]) * (a[k] + b[k]);
                middle[i] += a[i] / self.corners.len() as f64;
            }
        }
        let length = dot(normal, normal).sqrt();
        (middle, normal.map(|v| if length > 1e-12 { v / length } else { 0.0 }))
    }

    /// Whether a pixel is in the area: a ray from it crosses the border an odd number of times.
    fn covers(&self, [x, y]: [f64; 2]) -> bool {
        let edges = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        let crossed = edges.filter(|(a, b)| {
            let ([ax, ay], [bx, by]) = (a.px, b.px);
            (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax)
        });
        crossed.count() % 2 == 1
    }

    /// The place in the order of the items before which this area is painted: where the fewest items that it covers on
    /// the picture are on the wrong side of it, and among these the place of its mean depth.
    fn place(&self, items: &[Item], eye: [f64; 3]) -> usize {
        let usual = items.partition_point(|i| i.depth >= self.depth());
        let (middle, normal) = self.plane();
        let side = |p: [f64; 3]| dot(normal, p) - dot(normal, middle);
        let from = side(eye);
        // Seen edge-on or without an area, it has no sides.
        if from.abs() < 1e-3 {
            return usual;
        }
        // 1 in front of it, −1 behind, 0 beside it or in its plane.
        let sign = |item: &Item| {
            let to = side(item.middle.at) / from.signum();
            if to.abs() < 5e-3 || !self.covers(item.middle.px) { 0 } else { to.signum() as i64 }
        };
        let mut wrong = 0_i64;
        let (mut best, mut least) = (0, 0);
        for (i, item) in items.iter().enumerate() {
            // One place later, this item is painted before the area.
            wrong += sign(item);
            let closer = (i + 1).abs_diff(usual) < usual.abs_diff(best);
            if wrong < least || (wrong == least && closer) {
                (best, least) = (i + 1, wrong);
            }
        }
        best
    }
}

/// Paints all items and areas.
pub(super) fn paint(canvas: &mut Canvas, mut items: Vec<Item>, faces: &[Face], camera: &Camera) {
    items.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    let exact = faces.len() <= FACES;
    let place = |f: &Face| {
        if exact { f.place(&items, camera.eye()) } else { items.partition_point(|i| i.depth >= f.depth()) }
    };
    let mut placed: Vec<(usize, &Face)> = faces.iter().map(|f| (place(f), f)).collect();
    placed.sort_by(|(i, a), (j, b)| i.cmp(j).then(b.depth().total_cmp(&a.depth())));

    let mut brush = Brush::default();
    let mut placed = placed.into_iter().peekable();
    let mut rest = items.iter().enumerate().peekable();
    while let Some((i, item)) = rest.next() {
        while let Some((_, face)) = placed.next_if(|(at, _)| *at <= i) {
            brush.take(canvas, &face.group);
            canvas.path(face.class, &face.d, None);
        }
        if let Some((width, d)) = &item.halo {
            canvas.stroke("halo", Some(*width), d, None);
        }
        brush.take(canvas, &item.group);
        // Neighbours in the order that look the same become one path.
        let mut d = item.d.clone();
        let same = |next: &Item| {
            item.tip.is_none()
                && next.tip.is_none()
                && next.halo.is_none()
                && (&next.group, next.class, next.width) == (&item.group, item.class, item.width)
        };
        while let Some((_, next)) = rest.next_if(|(j, next)| placed.peek().is_none_or(|(at, _)| at > j) && same(next)) {
            d.push_str(&next.d);
        }
        canvas.stroke(item.class, item.width, &d, item.tip.as_deref());
    }
    for (_, face) in placed {
        brush.take(canvas, &face.group);
        canvas.path(face.class, &face.d, None);
    }
    brush.take(canvas, "");
}

/// The open group of a colour.
#[derive(Default)]
struct Brush {
    group: String,
}

impl Brush {
    fn take(&mut self, canvas: &mut Canvas, group: &str) {
        if self.group == group {
            return;
        }
        if !self.group.is_empty() {
            canvas.raw("</g>\n");
        }
        if !group.is_empty() {
            let open = format!("<g {}>\n", canvas.class(group));
            canvas.raw(&open);
        }
        group.clone_into(&mut self.group);
    }
}
