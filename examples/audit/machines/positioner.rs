//! A positioner of which only the coordinates of the pose are known.

use paracal::mechanism::{GeometryError, Mechanism, PosePositioner};
use paracal::pose::PoseConvention;

use super::{Design, Kind, Part, Spread};
use crate::dice::Dice;
use crate::rigid::Rigid;

/// Six offsets. Its coordinates are those of the origin of the platform, in the first order of rotations.
struct Positioner;

impl Kind for Positioner {
    fn name(&self) -> &'static str {
        "pose"
    }

    fn parts(&self) -> Vec<Part> {
        [[Part::Length; 3], [Part::Angle; 3]].concat()
    }

    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>> {
        Some(pose.written(&PoseConvention::default()).iter().zip(values).map(|(q, offset)| q - offset).collect())
    }

    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError> {
        let offsets: [f64; 6] = std::array::from_fn(|k| values[k]);
        let tolerance = Some([spread.length, spread.angle]);
        let convention = PoseConvention::default();
        Ok(Box::new(PosePositioner::new("audited positioner", convention, home.pose(), offsets, tolerance)?))
    }
}

pub(super) fn draw(dice: &mut Dice) -> Option<Design> {
    let size = dice.log_uniform(0.1, 3.0);
    let home = Rigid::shifted(dice.in_cube(size));
    let (shift, turn) = (dice.log_uniform(0.01, 0.2) * size, dice.log_uniform(1.0, 15.0).to_radians());
    let design = Design::new(Positioner, vec![0.0; 6], home, [shift, shift, shift, turn, turn, turn], size, size);
    Some(Design { carries_frames: false, has_platform: false, ..design })
}
