//! Evidence for a cause: residuals in the joints before and after, and added-variable plots.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::answer::result::{AddedVariable, JointResiduals};
use crate::diagnosis::linear::hypotheses::{EffectColumns, Hypotheses};
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::model::Model;
use crate::solve::minimum_norms;

/// What is left of each sample in the joints, without causes and with those of `judged`; both are models of the same rows.
pub(crate) fn joint_residuals(subject: &Hypotheses<'_>, without: &Model, judged: &Model) -> Vec<JointResiduals> {
    let table = without.table();
    let joints = &table.joints;
    let of = |k: usize| {
        let (first, n) = table.rows[k];
        let left_out = without.kept.is_out(k);
        let columns = table.a_t.view((joints.start, first), (joints.len(), n)).transpose();
        let residual = |model: &Model| match left_out {
            true => model.predicted(first, n).0,
            false => model.residual.rows(first, n).into_owned(),
        };
        // The residual is predicted minus measured.
        let found = minimum_norms(&columns, &-DMatrix::from_columns(&[residual(without), residual(judged)]));
        JointResiduals {
            row: subject.data.sample(k).row,
            left_out,
            before: found.column(0).iter().copied().collect(),
            after: found.column(1).iter().copied().collect(),
        }
    };
    (0..table.samples()).map(of).collect()
}

/// What is left without a cause over the share of the cause that nothing else imitates, row by row of the readings, both
/// over `sigma`, the noise of a row. `without` is the model of everything else, `values` are those of the cause.
pub(crate) fn added_variable(
    groups: &[EffectColumns],
    without: &Model,
    name: &Hypothesis,
    values: &[f64],
    sigma: f64,
) -> AddedVariable {
    let columns = without.kept.columns(&name.block(groups, without.table()));
    let share = &columns * DVector::from_column_slice(values);
    let share = without.projected(DMatrix::from_column_slice(share.len(), 1, share.as_slice()));
    let point = |row: usize| [share[row] / sigma, -without.residual[row] / sigma];
    let rows = without.kept.rows().flat_map(|(first, n)| first..first + n);
    AddedVariable { points: rows.map(point).collect() }
}
