//! What nature's laws may have in another form than the catalogue's effects.

use super::confirming::{Refit, adequacy, evidence};
use super::search::Search;
use super::thresholds::Thresholds;
use super::verdict::weight_of_one_among;
use crate::inference::fit::Fit;

/// Nature's law may deviate from the catalogue's by as much as `form` says, or by these parts of it.
const PARTS: [f64; 3] = [0.1, 0.3, 1.0];

impl Search<'_> {
    /// A refit beside errors of its effects' forms; `None` where one of them is a switch of which nothing is known.
    pub(super) fn beside_forms(&self, refit: &Refit) -> Option<Fit> {
        self.beside_forms_by(refit, self.thresholds.form)
    }

    /// The same beside errors of another part of what the effects do.
    fn beside_forms_by(&self, refit: &Refit, form: f64) -> Option<Fit> {
        let mut errors = vec![];
        for (k, change_mn) in refit.members.iter().zip(refit.changes_mn(self.candidates)) {
            // A switch has no magnitude that was fitted.
            let of_switch = || self.shown.iter().find(|s| s.candidate == *k).map(|s| s.change_mn.clone());
            let (effect, change_mn) = (&self.candidates[*k].effect, change_mn.or_else(of_switch)?);
            errors.extend(effect.errors_of_form(self.setup.observations, &change_mn, form));
        }
        Some(refit.fit.beside(errors))
    }

    /// Whether a single effect explains the data and leaves nothing but noise beside what its form may leave: then no second one is needed.
    pub(super) fn is_a_matter_of_form(&self, single: &Refit) -> bool {
        let rest = Some(single).filter(|r| r.meets_data(&self.thresholds)).and_then(|r| self.beside_forms(r));
        rest.is_some_and(|rest| adequacy(self.setup, &rest) > self.thresholds.significant)
    }

    /// Whether two effects are decidedly more likely than each single one in whatever form, by the prior odds of a pair and of this second
    /// among all. Where one of them alone leaves noise beside errors of its form, both leave noise without any.
    pub(super) fn is_needed(&self, pair: &Refit, singles: &[Refit], is_a_matter_of_form: bool) -> bool {
        let Thresholds { complexity, decisive, inadequate, .. } = self.thresholds;
        if is_a_matter_of_form && !pair.leaves_noise(inadequate) {
            return false;
        }
        let least =
            self.evidence_of_some_form(pair) - complexity - weight_of_one_among(self.rivals) - decisive;
        singles.iter().all(|single| self.evidence_of_some_form(single) < least)
    }

    /// Twice the log evidence of a refit, as it is or beside errors of its effects' forms, whichever is most likely.
    fn evidence_of_some_form(&self, refit: &Refit) -> f64 {
        let active = refit.active(self.candidates);
        let as_it_is = evidence(&refit.fit, &active);
        let beside = |part: f64| {
            let rest = self.beside_forms_by(refit, part * self.thresholds.form)?;
            Some(refit.evidence + evidence(&rest, &active) - as_it_is)
        };
        PARTS.into_iter().filter_map(beside).fold(refit.evidence, f64::max)
    }
}
