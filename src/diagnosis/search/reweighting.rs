//! Rows weighted by the noise that they have: iteratively reweighted least squares around the search.
//!
//! The search begins with the noise as stated. What its residuals say about the noise changes the weights of the rows, and
//! the search is made again with these; each of the questions below is asked once, in this order.

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::spreads::Spreads;
use crate::diagnosis::search::covariates::covariates;
use crate::diagnosis::search::iteration::{Search, SearchState};
use crate::diagnosis::search::noise;
use crate::diagnosis::search::outliers::distances;

/// What the noise may depend on.
#[derive(Clone, Copy, Debug)]
enum DependsOn {
    /// The joint; in pose space, where nothing says how the noise of the six coordinates compares, and each is fitted by
    /// itself.
    Joint,
    /// Position or rotation.
    Kind,
    /// A covariate of the sample.
    Covariate,
}

impl Search<'_, '_> {
    /// The search, with weights that agree with the residuals that it leaves.
    pub(crate) fn reweighted(&self) -> Result<SearchState, DiagnoseError> {
        let mut state = self.with_spreads(&Spreads::default())?;
        let mut noise_varies = None;
        for question in [DependsOn::Joint, DependsOn::Kind, DependsOn::Covariate] {
            let before = &state.spreads;
            let spreads = match question {
                DependsOn::Joint if self.subject.is_pose_space() && !self.subject.data.noise.known => {
                    let (table, kept) = (state.model.table(), state.kept());
                    Spreads { joints: table.spreads_of(&state.model.residual, kept.rows()), ..before.clone() }
                }
                DependsOn::Kind if !self.known && before.joints.is_empty() => match noise::ratio(&state.model) {
                    Some(kinds) => Spreads { kinds: Some(kinds), ..before.clone() },
                    None => continue,
                },
                DependsOn::Covariate => {
                    let known = covariates(self.subject.data, &self.subject.environment.condition_kinds);
                    let kept = state.kept().samples();
                    let Some((varies, samples)) = noise::noise_varies(&distances(&state.model), &known, &kept) else {
                        continue;
                    };
                    noise_varies = Some(varies);
                    Spreads { samples, ..before.clone() }
                }
                DependsOn::Joint | DependsOn::Kind => continue,
            };
            state = self.with_spreads(&spreads)?;
        }
        Ok(SearchState { noise_varies, ..state })
    }
}
