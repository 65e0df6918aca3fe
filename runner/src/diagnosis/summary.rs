//! From findings to the structure that is written.

use super::confirming::{Refit, adequacy};
use super::diagnose::Findings;
use super::location::{Pattern, Spot};
use super::result::*;
use super::round::{is_testable, linear_evidence};
use super::screening::Screened;
use super::shrinkage::Comparison;
use super::simple_rules::simple_rules;
use super::true_force::draws_of_noise_mn;
use super::wording;
use crate::data::Phase;
use crate::inference::FitParameter;
use crate::inference::Setup;
use crate::inference::effect::is_continuous;
use crate::inference::wording::list;
use crate::inspection::Inspection;
use crate::noise::Observation;
use crate::noise::observation::left_out;
use nalgebra::DVector;

/// What is told beside the findings.
pub struct About<'a> {
    /// Engine and parameters.
    pub setup: Setup<'a>,
    /// Inspection of the measurements.
    pub inspection: &'a Inspection,
    /// Command that was given.
    pub command: String,
    /// Whether only the leaders were refitted.
    pub quick: bool,
    /// A gap of a smaller part of the peak does not matter (%).
    pub matters_percent: f64,
    /// Wall time (s).
    pub seconds: f64,
}

/// The structure.
pub fn summary(f: &Findings, about: &About) -> Diagnosis {
    let threshold = f.round.significance.family.threshold(f.thresholds.significant);
    let members = &f.conclusion.decision.members;
    let name = |k: &usize| f.candidates[*k].name.clone();
    let (held_out, shrinkage) =
        f.conclusion.decision.refit.map_or((vec![], None), |k| held_out(f, &f.round.refits[k]));
    let effects: Vec<EffectSummary> = f.round.screened.iter().map(|s| effect(f, s, threshold)).collect();
    let not_testable = not_testable(f, &effects);
    let names: Vec<String> = members.iter().map(name).collect();
    let mut diagnosis = Diagnosis {
        schema: SCHEMA.to_owned(),
        command: about.command.clone(),
        quick: about.quick,
        verdict: Verdict {
            kind: f.conclusion.decision.kind,
            effects: names,
            confidence: f.conclusion.decision.confidence,
            gap_percent: f.conclusion.gap_percent,
            is_immaterial: f.conclusion.decision.is_immaterial,
            matters_percent: about.matters_percent,
            text: String::new(),
        },
        assumptions: vec![],
        tests: f.observations.iter().enumerate().map(|(i, o)| test(f, i, o)).collect(),
        parity: super::parity::parity(about.inspection),
        baseline: plain(f, about),
        location: location(f, threshold),
        overlap: overlap(&f.round.screened),
        models: models(f, about),
        something_else_evidence: f.round.something_else.evidence,
        held_out,
        shrinkage,
        not_testable,
        simple_rules: simple_rules(&f.round.plain, &f.round.screened, &f.candidates, &f.round.spots),
        leftover: f.conclusion.leftover.clone(),
        proposals: f.conclusion.proposals.clone(),
        next: members.iter().map(|k| wording::next(&f.candidates[*k])).collect(),
        warnings: warnings(f),
        curves: curves(f),
        effects,
        seconds: about.seconds,
    };
    diagnosis.verdict.text = wording::headline(&diagnosis);
    diagnosis
}

fn test(f: &Findings, i: usize, o: &Observation) -> TestSummary {
    let noise = &f.noise.tests[i];
    TestSummary {
        name: o.name().to_owned(),
        points: o.len(),
        cycles: o.cycle.iter().max().map_or(0, |c| c + 1),
        left_out: (!o.left_out.is_empty()).then(|| o.left_out.join("; ")),
        specimens: o.factors.len(),
        noise: NoiseSummary {
            specimen_white_mn: noise.specimen_white_mn,
            white_mn: crate::data::measurement::median(&mut noise.white_mn.as_slice().to_vec()),
            slow_noise: noise.slow_mn,
            height_scatter: noise.height_scatter,
            same_specimens: f.noise.same_specimens,
        },
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0usize), |(s, n), v| (s + v * v, n + 1));
    (sum / n.max(1) as f64).sqrt()
}

fn parameters(about: &About, x: &[f64]) -> Vec<(String, f64, String)> {
    let values = about.setup.unknowns.settings(x);
    let one = |p: &FitParameter| (p.name.clone(), p.unit.from_si(values[&p.name]), p.unit.name.clone());
    about.setup.unknowns.free().iter().map(one).collect()
}

fn plain(f: &Findings, about: &About) -> ModelSummary {
    ModelSummary {
        effects: vec![],
        chi_square: f.round.plain.solution.chi_square,
        points: f.round.plain.gap_mn.len(),
        gain: 0.0,
        evidence: 0.0,
        probability: f64::from(u8::from(f.conclusion.decision.kind == Kind::NoGap))
            * f.conclusion.decision.confidence,
        magnitudes: vec![],
        adequacy: adequacy(Setup { observations: &f.observations, ..about.setup }, &f.round.plain),
        parameters: parameters(about, f.round.plain.x()),
        rms_mn: rms(f.round.plain.gap_mn.iter().copied()),
    }
}

fn models(f: &Findings, about: &About) -> Vec<ModelSummary> {
    let one = |(k, r): (usize, &Refit)| {
        let deviations = r.fit.magnitude_deviations();
        let mut free = r.fit.magnitudes().iter().copied().zip(deviations);
        let magnitude = |m: &usize| match is_continuous(&f.candidates[*m]) {
            true => free.next().unwrap_or((0.0, f64::INFINITY)),
            false => (1.0, 0.0),
        };
        ModelSummary {
            effects: r.members.iter().map(|m| f.candidates[*m].name.clone()).collect(),
            chi_square: r.fit.solution.chi_square,
            points: r.fit.gap_mn.len(),
            gain: r.gain,
            evidence: r.evidence,
            probability: f.conclusion.decision.probabilities[k],
            magnitudes: r.members.iter().map(magnitude).collect(),
            adequacy: r.adequacy,
            parameters: parameters(about, r.fit.x()),
            rms_mn: rms(r.fit.gap_mn.iter().copied()),
        }
    };
    let mut all: Vec<ModelSummary> = f.round.refits.iter().enumerate().map(one).collect();
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    all
}

fn location(f: &Findings, threshold: f64) -> Location {
    let y = &f.round.plain.linear.residual;
    let one = |s: &Spot| {
        let score = s.signature.score(y);
        let gap = || s.points.iter().map(|&i| f.round.plain.gap_mn[i]);
        let (pattern, time_s) = match s.pattern {
            Pattern::Level => ("level", None),
            Pattern::Tilt => ("tilt", None),
            Pattern::Relaxation(time_s) => ("relaxation", Some(time_s)),
        };
        SpotSummary {
            test: f.observations[s.test].name().to_owned(),
            cycle: s.cycle.map(|c| c + 1),
            phase: s.phase,
            pattern: pattern.to_owned(),
            time_s,
            score,
            mean_mn: gap().sum::<f64>() / s.points.len().max(1) as f64,
            rms_mn: rms(gap()),
            probability: f.round.significance.family.probability(score.abs()),
        }
    };
    Location {
        threshold,
        probability: f.round.significance.probability,
        spots: f.round.spots.iter().map(one).collect(),
    }
}

fn effect(f: &Findings, s: &Screened, threshold: f64) -> EffectSummary {
    let (candidate, y) = (&f.candidates[s.candidate], &f.round.plain.linear.residual);
    let effect = &candidate.effect;
    let score = s.signature.score(y);
    let (magnitude, magnitude_sigma) = s.signature.magnitude(y);
    let like = |o: &&Screened| o.candidate != s.candidate && s.signature.looks_like(&o.signature);
    let gain = f.round.refits.iter().find(|r| r.members == [s.candidate]).map(|r| r.gain);
    EffectSummary {
        name: candidate.name.clone(),
        family: effect.family.clone(),
        title: effect.title.clone(),
        place: effect.place,
        sign: effect.sign,
        score,
        probability: f.round.significance.family.probability(candidate.one_sided(score)),
        magnitude,
        magnitude_sigma,
        scale: effect.scale,
        unit: effect.unit.clone(),
        predicted_gain: score * score,
        actual_gain: gain,
        absorbed: s.signature.absorbed(),
        power: s.signature.strength(),
        evidence: linear_evidence(candidate, &s.signature, &f.round.plain.linear.residual),
        testable: is_testable(candidate, &s.signature, score, threshold),
        group: f.round.screened.iter().filter(like).map(|o| f.candidates[o.candidate].name.clone()).collect(),
    }
}

fn overlap(screened: &[Screened]) -> Vec<Vec<f64>> {
    let row = |a: &Screened| screened.iter().map(|b| a.signature.cosine(&b.signature)).collect();
    screened.iter().map(row).collect()
}

fn not_testable(f: &Findings, effects: &[EffectSummary]) -> Vec<NotTestable> {
    let weak = effects.iter().filter(|e| !e.testable).map(|e| NotTestable {
        name: e.name.clone(),
        reason: wording::too_weak(e, f.round.significance.family.threshold(f.thresholds.significant)),
    });
    let failed = f.round.failed.iter().map(|failed| NotTestable {
        name: f.candidates[failed.candidate].name.clone(),
        reason: format!("the model cannot be computed with it: {}", failed.reason),
    });
    let left_out =
        f.left_out.iter().map(|l| NotTestable { name: l.name.clone(), reason: l.reason.to_owned() });
    weak.chain(failed).chain(left_out).collect()
}

/// Places of the predicted points that belong to a phase; all where there is none.
fn part(phases: &[Phase], predicted: &[usize], phase: Option<Phase>) -> Vec<usize> {
    (0..predicted.len()).filter(|&i| phase.is_none_or(|p| phases[predicted[i]] == p)).collect()
}

fn held_out(f: &Findings, refit: &Refit) -> (Vec<HeldOut>, Option<ShrinkageSummary>) {
    let mut all = Vec::new();
    let mut total: Option<ShrinkageSummary> = None;
    let measured: Vec<f64> = f.observations.iter().flat_map(Observation::force_mn).collect();
    let phases: Vec<Phase> = f.observations.iter().flat_map(|o| o.phases.iter().copied()).collect();
    let noises_mn = draws_of_noise_mn(refit, &f.observations, &f.candidates, f.thresholds.form);
    for (split, chosen) in &f.splits {
        let chosen = chosen.map_or(refit, |k| &f.round.refits[k]);
        let compared = Comparison::of(&f.round.plain, chosen, split, &f.candidates, &f.thresholds);
        let Some(c) = compared else { continue };
        let chosen: Vec<String> = chosen.members.iter().map(|k| f.candidates[*k].name.clone()).collect();
        let mut parts = Vec::new();
        for phase in std::iter::once(None).chain(Phase::ALL.map(Some)) {
            let points = part(&phases, &split.predicted, phase);
            if points.is_empty() {
                continue;
            }
            let s = c.shrinkage(&points, &noises_mn);
            parts.push(PartGap {
                part: phase.map_or("total", Phase::name).to_owned(),
                before_mn: s.before_mn,
                after_mn: s.after_mn,
                shrinkage: s.value,
                interval: s.interval,
            });
            // The split with the largest significant gap says most about how much of it goes.
            let size = |value: Option<f64>, before_mn: f64| (value.is_some(), before_mn);
            let larger =
                total.as_ref().is_none_or(|t| size(s.value, s.before_mn) > size(t.value, t.before_mn));
            if phase.is_none() && c.informative && larger {
                total = Some(ShrinkageSummary {
                    of: split.name.clone(),
                    chosen: chosen.clone(),
                    before_mn: s.before_mn,
                    after_mn: s.after_mn,
                    value: s.value,
                    interval: s.interval,
                    points: split.predicted.clone(),
                    predicted_before_mn: c.predicted_mn(&measured, false),
                    predicted_after_mn: c.predicted_mn(&measured, true),
                });
            }
        }
        all.push(HeldOut {
            split: split.name.clone(),
            chosen,
            score: c.score,
            informative: c.informative,
            parts,
        });
    }
    (all, total)
}

fn warnings(f: &Findings) -> Vec<String> {
    let mut warnings: Vec<String> = left_out(&f.observations).collect();
    if !f.round.plain.solution.stop.converged() {
        warnings.push(format!("the fit of the plain model: {}", f.round.plain.solution.stop));
    }
    if f.observations.len() < 2 && f.splits.is_empty() {
        warnings.push("one cycle of one test: nothing can be predicted that was not fitted".to_owned());
    }
    if !f.conclusion.decision.unnamed.is_empty() {
        let names: Vec<&str> =
            f.conclusion.decision.unnamed.iter().map(|&k| f.candidates[k].name.as_str()).collect();
        warnings.push(match f.conclusion.decision.kind {
            Kind::NoGap => format!("what is significant of the difference looks like {}", list(&names)),
            _ => format!("less likely, but not told from the effects named: {}", list(&names)),
        });
    }
    if f.noise.tests.iter().all(|t| t.height_scatter.is_none()) {
        warnings.push("no specimens in the files: what they differ by is not in the noise".to_owned());
    }
    warnings
}

fn curves(f: &Findings) -> Vec<CurvePair> {
    let sigma = f.round.plain.covariance.total_mn();
    let after = f.conclusion.decision.refit.map(|k| &f.round.refits[k].fit.gap_mn);
    let mut before = 0;
    let mut all = Vec::new();
    for o in &f.observations {
        let (n, measured_mn) = (o.len(), o.force_mn());
        let model = |gap: &DVector<f64>| -> Vec<f64> {
            measured_mn.iter().enumerate().map(|(i, m)| m - gap[before + i]).collect()
        };
        all.push(CurvePair {
            name: o.name().to_owned(),
            time_s: o.measurement.time_s.clone(),
            specimens_mn: specimens_mn(o),
            sigma_mn: sigma.rows(before, n).as_slice().to_vec(),
            before_mn: model(&f.round.plain.gap_mn),
            after_mn: after.map(model),
            measured_mn,
        });
        before += n;
    }
    all
}

fn specimens_mn(o: &Observation) -> Vec<Vec<f64>> {
    let whole = o.measurement.specimens_n.iter().filter(|s| s.len() == o.len());
    whole.map(|s| s.iter().map(|f| f * 1e3).collect()).collect()
}
