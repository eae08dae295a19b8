//! Evidence for a cause: residuals in the joints before and after, and added-variable plots.

use nalgebra::DVector;

use crate::diagnosis::answer::result::{AddedVariable, JointResiduals};
use crate::diagnosis::linear::hypotheses::{EffectColumns, Hypotheses};
use crate::diagnosis::linear::model::{Hypothesis, Model, columns_of};
use crate::diagnosis::search::iteration::SearchState;
use crate::solve::minimum_norm;

/// What is left of each sample in the joints, without causes and with those of `judged`.
pub(crate) fn joint_residuals(
    subject: &Hypotheses<'_>,
    state: &SearchState,
    without: &Model<'_>,
    judged: &Model<'_>,
) -> Vec<JointResiduals> {
    let full = &state.full;
    let joints = &full.joints;
    let of = |k: usize| {
        let (first, n) = full.rows[k];
        let left_out = state.left_out.contains(&k);
        let columns = full.a.view((first, joints.start), (n, joints.len())).into_owned();
        let in_joints = |model: &Model<'_>| {
            let residual = match left_out {
                true => model.predicted(full, &subject.groups, first, n).0,
                false => model.residual.rows(first, n).into_owned(),
            };
            // The residual is predicted minus measured.
            minimum_norm(columns.clone(), &-residual).iter().copied().collect()
        };
        JointResiduals {
            row: subject.data.sample(k).row,
            left_out,
            before: in_joints(without),
            after: in_joints(judged),
        }
    };
    (0..full.samples()).map(of).collect()
}

/// What is left without a cause over the share of the cause that nothing else imitates, row by row of the readings, both
/// over `sigma`, the noise of a row. `without` is the model of everything else, `values` are those of the cause.
pub(crate) fn added_variable(
    state: &SearchState,
    groups: &[EffectColumns],
    without: &Model<'_>,
    name: &Hypothesis,
    values: &[f64],
    sigma: f64,
) -> AddedVariable {
    let columns = without.projected(&columns_of(&state.table, groups, name));
    let share = columns * DVector::from_column_slice(values);
    let point = |row: usize| [share[row] / sigma, -without.residual[row] / sigma];
    let rows = state.table.kept_rows(&state.left_out).flat_map(|(first, n)| first..first + n);
    AddedVariable { points: rows.map(point).collect() }
}
