//! Drawings of mechanisms in perspective.
//!
//! A [`Scene`] holds what is seen, in metres and with z upwards: closed polygons ([`Silhouette`]: base ring, platform,
//! platform at other poses), legs and cables ([`LineSegment`]), coordinate systems ([`Triad`]), errors or loads
//! ([`Arrow`]) and points ([`Dot`]). A [`View`] is the viewpoint.
//!
//! * **True perspective.**  The projection is the one of a pinhole camera, fitted into the picture. Lengths cannot be
//!   read from such a picture with a ruler; hence a grid lies on the ground, at the lowest z of all that is drawn, and
//!   the text below the picture states how large its squares are. Tooltips give the lengths of the legs.
//! * **Near hides far.**  Lines are cut into short pieces and painted from far to near, translucent areas between the
//!   pieces behind and in front of them. Nearer lines are wider and stronger, and legs interrupt what they pass over.
//! * **Labels do not collide.**  Each label takes the one of several places that hides the least; when none is free, it
//!   remains in the tooltip.
//! * **Any data gives a picture.**  Points that are not finite or beyond 1e100 m are left out, with the lines that end
//!   there. A scene without points shows a grid around the origin.

mod camera;
mod labels;
mod layout;
mod lines;
mod order;
mod shapes;
mod stage;
#[cfg(test)]
mod tests;

/// A mechanism and what happens to it, seen in perspective.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Heading, drawn above the picture.
    pub title: String,
    /// Text alternative: what is seen, in a sentence or two.
    pub description: String,
    /// Unit of the lengths that are written: its name, and the metres in it. A size that is not between 1e-9 and 1e9
    /// stands for metres.
    pub unit: (&'static str, f64),
    /// From where it is seen.
    pub view: View,
    /// Closed polygons.
    pub outlines: Vec<Silhouette>,
    /// Legs, cables, arms.
    pub legs: Vec<LineSegment>,
    /// Coordinate systems.
    pub frames: Vec<Triad>,
    /// Arrows.
    pub arrows: Vec<Arrow>,
    /// Points.
    pub dots: Vec<Dot>,
    /// A remark below the picture, such as "Arrows are 2000 times as long as the errors."; may be empty.
    pub note: String,
}

impl Scene {
    /// The picture as SVG text. The prefix of its ids is derived from the content.
    #[must_use]
    pub fn svg(&self) -> String {
        self.svg_with_id(&super::figure::default_id(self))
    }

    /// The picture as SVG text, with an id prefix that keeps the ids of several inline pictures on one page apart.
    ///
    /// Characters of the prefix that are not allowed in a style sheet are replaced by `-`.
    #[must_use]
    pub fn svg_with_id(&self, id: &str) -> String {
        layout::compose(self, id, layout::WHOLE).finish(&self.title, &self.description)
    }

    /// The picture for a page, once for wide screens and once for narrow ones and for paper;
    /// [`PAGE_STYLE`](super::PAGE_STYLE) shows the one that fits.
    #[must_use]
    pub fn html_with_id(&self, id: &str) -> String {
        let narrow = layout::compose(self, &format!("{id}-narrow"), layout::NARROW);
        format!(
            "<div class=\"whole few\">{}</div><div class=\"panels few\"><div>{}</div></div>",
            self.svg_with_id(id),
            narrow.finish(&self.title, &self.description)
        )
    }
}

impl Scene {
    /// The picture for a page on which nothing stands beside it: as [`html_with_id`](Self::html_with_id), and once more as
    /// wide as a wide screen.
    #[must_use]
    pub fn html_alone(&self, id: &str) -> String {
        let draw = |id: &str, size| layout::compose(self, id, size).finish(&self.title, &self.description);
        format!(
            "<div class=\"full\">{}</div><div class=\"whole few middle\">{}</div><div class=\"panels few\"><div>{}</div></div>",
            draw(&format!("{id}-wide"), layout::WIDE),
            draw(id, layout::WHOLE),
            draw(&format!("{id}-narrow"), layout::NARROW)
        )
    }
}

/// The direction and the distance from which a scene is seen. The camera always aims at the middle of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Direction from the scene to the camera about z, in rad: 0 is a camera on the side of positive x, seen from
    /// which y points to the right; −π/2 is one on the side of negative y, seen from which x points to the right.
    pub azimuth: f64,
    /// Height of the camera above the horizon, in rad, at most ±π/2.
    pub elevation: f64,
    /// Distance of the camera from the middle of the scene, in radii of the scene; at least 1.5. Far away the picture
    /// becomes a parallel projection.
    pub distance: f64,
}

impl Default for View {
    /// A three-quarter view from the side of negative y, a little from the right and from above.
    fn default() -> Self {
        Self { azimuth: -1.1, elevation: 0.42, distance: 4.0 }
    }
}

/// A closed polygon: a ring, a platform, a frame. Two points are a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Silhouette {
    /// Name in the legend; without a name it is not in the legend. Things of the same name share one entry.
    pub name: String,
    /// Index into the palette (cyclic).
    pub colour: usize,
    /// Corners in order, x, y and z in metres; the last one is joined with the first one.
    pub points: Vec<[f64; 3]>,
    /// Whether its area is tinted, so that what is behind shines through.
    pub filled: bool,
    /// Whether it is drawn thin and faint, for one of many poses.
    pub thin: bool,
}

/// A straight leg, cable or part of an arm, with a joint at each end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineSegment {
    /// Name in the legend; may be empty.
    pub name: String,
    /// Index into the palette (cyclic).
    pub colour: usize,
    /// One end: x, y and z in metres.
    pub from: [f64; 3],
    /// The other end: x, y and z in metres.
    pub to: [f64; 3],
    /// Short label beside the leg, such as its number; may be empty.
    pub label: String,
}

/// A coordinate system, drawn as three arrows with the letters x, y and z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triad {
    /// Label beside the origin; may be empty.
    pub label: String,
    /// Origin: x, y and z in metres.
    pub origin: [f64; 3],
    /// Unit vectors along x, y and z of the coordinate system.
    pub axes: [[f64; 3]; 3],
    /// Length of the arrows in metres.
    pub length: f64,
}

/// An arrow: an error, a force.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrow {
    /// Name in the legend; may be empty.
    pub name: String,
    /// Index into the palette (cyclic).
    pub colour: usize,
    /// Foot: x, y and z in metres.
    pub from: [f64; 3],
    /// Head: x, y and z in metres, magnified already.
    pub to: [f64; 3],
    /// Tooltip; may be empty. A scene with more than 400 arrows shows none.
    pub tip: String,
    /// Short label beside its head; may be empty.
    pub label: String,
}

/// A point with a marker whose shape depends on the colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dot {
    /// Name in the legend; may be empty.
    pub name: String,
    /// Index into the palette (cyclic); it selects the shape of the marker as well.
    pub colour: usize,
    /// Place: x, y and z in metres.
    pub at: [f64; 3],
    /// Tooltip; may be empty. A scene with more than 400 dots shows none.
    pub tip: String,
}
