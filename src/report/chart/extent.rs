//! The ranges of the data of a panel along its axes.

use super::axis::Extent;
use super::{Axis, Panel, Series, Shape};

/// Room for circles at both ends of an axis, as a part of it.
const CIRCLE: f64 = 0.05;

/// Whether a series belongs to the axis on the right.
pub(super) fn on_right(panel: &Panel, series: &Series) -> bool {
    series.right && panel.right.is_some()
}

/// Range of y of the series on one side, with the horizontal rules on the left.
pub(super) fn y_extent(panel: &Panel, axis: &Axis, right: bool) -> Extent {
    let mut extent = Extent::new(axis);
    let x_views = Extent::new(&panel.x);
    for series in panel.series.iter().filter(|s| on_right(panel, s) == right) {
        for (i, [_, y]) in series.points.iter().enumerate().filter(|(_, p)| x_views.takes(p[0])) {
            extent.add(*y);
            match &series.shape {
                Shape::Bars { .. } => extent.add_foot(*y),
                Shape::ErrorBars { ends } => ends.get(i).into_iter().flatten().for_each(|v| extent.add(*v)),
                Shape::Band { lower } => lower.get(i).into_iter().for_each(|v| extent.add(*v)),
                _ => {}
            }
        }
    }
    if !right {
        panel.rules.iter().filter(|r| r.horizontal).for_each(|r| extent.add(r.at));
    }
    pad_circles(panel, &mut extent);
    extent
}

/// Circles at the ends of an axis would lie on its labels.
fn pad_circles(panel: &Panel, extent: &mut Extent) {
    if panel.series.iter().any(|s| matches!(s.shape, Shape::Bubbles { .. })) {
        extent.pad(CIRCLE);
    }
}

/// Range of x of all series and the vertical rules.
pub(super) fn x_extent(panel: &Panel) -> Extent {
    let mut extent = Extent::new(&panel.x);
    for series in &panel.series {
        for [x, _] in &series.points {
            extent.add(*x);
            if let Shape::Bars { width } = series.shape
                && width.is_finite()
            {
                extent.add(x - width.abs() / 2.0);
                extent.add(x + width.abs() / 2.0);
            }
        }
    }
    panel.rules.iter().filter(|r| !r.horizontal).for_each(|r| extent.add(r.at));
    pad_circles(panel, &mut extent);
    extent
}
