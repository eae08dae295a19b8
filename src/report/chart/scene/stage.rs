//! The extent of a scene, the ground, and the way from metres to pixels.

use super::Scene;
use super::camera::{Camera, distance};
use crate::report::chart::axis::nice_step;

/// Coordinates beyond this, in metres, are not drawn: their squares would overflow.
const FARTHEST: f64 = 1e100;
/// So many squares of the ground, at most, lie along the longer side of the scene.
const SQUARES: f64 = 12.0;

/// The unit of the lengths: its name, and the metres in it.
pub(super) fn unit(scene: &Scene) -> (&'static str, f64) {
    let (name, size) = scene.unit;
    if (1e-9..=1e9).contains(&size) { (name, size) } else { ("m", 1.0) }
}

/// Whether a point can be drawn.
pub(super) fn drawable(p: &[f64; 3]) -> bool {
    p.iter().all(|v| v.abs() < FARTHEST)
}

/// All points of a scene that can be drawn.
fn points(scene: &Scene) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = scene.outlines.iter().flat_map(|o| &o.points).copied().collect();
    all.extend(scene.legs.iter().flat_map(|s| [s.from, s.to]));
    all.extend(scene.arrows.iter().flat_map(|a| [a.from, a.to]));
    all.extend(scene.dots.iter().map(|d| d.at));
    for frame in &scene.frames {
        all.push(frame.origin);
        all.extend(frame.axes.map(|axis| tip(frame.origin, axis, frame.length)));
    }
    all.retain(drawable);
    all
}

/// The end of an axis of a triad.
pub(super) fn tip(origin: [f64; 3], axis: [f64; 3], length: f64) -> [f64; 3] {
    std::array::from_fn(|i| origin[i] + length * axis[i])
}

/// The grid on the ground, in metres.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ground {
    pub step: f64,
    pub z: f64,
    pub low: [f64; 2],
    /// Number of squares along x and y.
    pub count: [usize; 2],
}

impl Ground {
    /// A grid of nice squares, in multiples of the unit, that reaches beyond the box of the scene.
    fn below(low: [f64; 3], high: [f64; 3], least: f64, unit: f64) -> Self {
        let span = |i: usize| high[i] - low[i];
        // A tall scene on a small base needs no finer squares than its height does.
        let longest = span(0).max(span(1)).max(0.4 * span(2)).max(least);
        let step = nice_step(longest / SQUARES / unit).0 * unit;
        let first = |i: usize| (low[i] / step - 0.05).floor();
        let last = |i: usize| (high[i] / step + 0.05).ceil();
        let count = |i: usize| (last(i) - first(i)).clamp(1.0, 50.0) as usize;
        Self { step, z: low[2], low: [first(0) * step, first(1) * step], count: [count(0), count(1)] }
    }

    /// The ends of all its lines, in metres.
    pub(super) fn lines(&self) -> Vec<[[f64; 3]; 2]> {
        let at = |i: usize, j: usize| [self.low[0] + i as f64 * self.step, self.low[1] + j as f64 * self.step, self.z];
        let [nx, ny] = self.count;
        let along_y = (0..=nx).map(|i| [at(i, 0), at(i, ny)]);
        along_y.chain((0..=ny).map(|j| [at(0, j), at(nx, j)])).collect()
    }
}

/// A point on its way into the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// In the scene, in its radii from its middle.
    pub at: [f64; 3],
    /// In the picture, in pixels.
    pub px: [f64; 2],
    /// Distance from the camera along its axis, in radii of the scene.
    pub depth: f64,
}

/// A scene before the camera.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    pub camera: Camera,
    pub ground: Ground,
    centre: [f64; 3],
    radius: f64,
    /// Pixels per radius, and the pixel of the middle of the scene.
    scale: f64,
    shift: [f64; 2],
    /// Depths of the nearest and the farthest thing on the ground.
    range: (f64, f64),
    /// Height of the picture in pixels.
    pub height: f64,
}

impl Stage {
    /// Puts the scene into a part of the picture: its upper left corner, its width and largest height, and the margin
    /// inside of it.
    pub(super) fn new(scene: &Scene, corner: [f64; 2], [width, tallest]: [f64; 2], pad: f64) -> Self {
        let all = points(scene);
        let end = |i: usize, pick: fn(f64, f64) -> f64| all.iter().map(|p| p[i]).reduce(pick).unwrap_or(0.0);
        let low: [f64; 3] = std::array::from_fn(|i| end(i, f64::min));
        let high: [f64; 3] = std::array::from_fn(|i| end(i, f64::max));
        let unit = unit(scene).1;
        let far = low.iter().chain(&high).fold(0.0_f64, |m, v| m.max(v.abs()));
        // Less than the rounding errors of the coordinates, or no extent at all, is a single point on one square.
        let least = if low == high { unit.max(1e-9 * far) } else { (1e-9 * far).max(1e-90) };
        let ground = Ground::below(low, high, least, unit);
        let corners: Vec<[f64; 3]> = ground.lines().into_iter().flatten().collect();
        let (mut low, mut high) = (low, high);
        for p in &corners {
            low = std::array::from_fn(|i| low[i].min(p[i]));
            high = std::array::from_fn(|i| high[i].max(p[i]));
        }
        let centre = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let radius = all.iter().chain(&corners).map(|p| distance(*p, centre)).fold(0.0, f64::max).max(1e-95);

        let camera = Camera::new(&scene.view);
        let mut stage =
            Self { camera, ground, centre, radius, scale: 1.0, shift: [0.0; 2], range: (0.0, 0.0), height: 0.0 };
        let seen: Vec<Spot> = all.iter().chain(&corners).map(|p| stage.spot(*p)).collect();
        let over = |i: usize| {
            let px = seen.iter().map(|s| s.px[i]);
            (px.clone().fold(f64::INFINITY, f64::min), px.fold(f64::NEG_INFINITY, f64::max))
        };
        let ((x0, x1), (y0, y1)) = (over(0), over(1));
        let (w, h) = (width - 2.0 * pad, tallest - 2.0 * pad);
        stage.scale = (w / (x1 - x0).max(1e-6)).min(h / (y1 - y0).max(1e-6));
        stage.height = ((y1 - y0) * stage.scale + 2.0 * pad).max(0.35 * tallest);
        stage.shift = [
            corner[0] + 0.5 * width - 0.5 * (x0 + x1) * stage.scale,
            corner[1] + 0.5 * stage.height - 0.5 * (y0 + y1) * stage.scale,
        ];
        let depths = seen.iter().map(|s| s.depth);
        stage.range = (depths.clone().fold(f64::INFINITY, f64::min), depths.fold(f64::NEG_INFINITY, f64::max));
        stage
    }

    fn spot(&self, p: [f64; 3]) -> Spot {
        let at = std::array::from_fn(|i| (p[i] - self.centre[i]) / self.radius);
        self.project(at)
    }

    /// A point given in radii from the middle of the scene.
    pub(super) fn project(&self, at: [f64; 3]) -> Spot {
        let (px, depth) = self.camera.project(at);
        Spot { at, px: std::array::from_fn(|i| self.shift[i] + self.scale * px[i]), depth }
    }

    /// A point given in metres, if it can be drawn.
    pub(super) fn see(&self, p: &[f64; 3]) -> Option<Spot> {
        drawable(p).then(|| self.spot(*p))
    }

    /// The depth at which something is so far back.
    pub(super) fn depth_of(&self, back: f64) -> f64 {
        self.range.0 + back * (self.range.1 - self.range.0)
    }

    /// How far back a depth is: 0 for the nearest, 1 for the farthest.
    pub(super) fn back(&self, depth: f64) -> f64 {
        let (near, far) = self.range;
        ((depth - near) / (far - near).max(1e-9)).clamp(0.0, 1.0)
    }
}
