//! Answers against the key.

use super::binomial::Share;
use super::calibration::Calibration;
use super::description;
use super::draw::Kind as CaseKind;
use super::ground::{Ground, factor_off_table_1};
use super::key::{Key, Solution};
use super::noise::shared_height;
use crate::data::measurement::median;
use crate::diagnosis::result::{Diagnosis, Kind};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Largest group that is an answer.
const LARGEST_GROUP: usize = 3;
/// From this factor between one of its parameters and Table 1's a material is far off it. Those of the wide ground are up to ten times
/// off in each: about a third of them are nowhere as far as this.
pub const FAR: f64 = 7.0;

/// How one case was answered.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Line {
    /// Case.
    pub id: String,
    /// What was behind it.
    pub truth: String,
    /// Score of its weakest cause for somebody who knows it, where there is one.
    pub visibility: Option<f64>,
    /// What its smallest cause leaves of the largest force (%), where there is one.
    pub gap_percent: Option<f64>,
    /// What was answered.
    pub answer: String,
    /// Confidence of the answer.
    pub confidence: f64,
    /// Whether it is right.
    pub right: bool,
    /// Shrinkage with its interval.
    pub shrinkage: Option<(f64, f64, f64)>,
    /// The true one.
    pub true_shrinkage: Option<f64>,
}

/// The table of the design, section 7.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Scores {
    /// Cases without a gap that were accused of one.
    pub false_accusations: Share,
    /// Visible single effects that matter, named first.
    pub top_1: Share,
    /// Visible single effects that matter, within a group of at most three.
    pub in_group: Share,
    /// Answers that name an effect.
    pub accusations: u64,
    /// Effects that these name.
    pub named: u64,
    /// Causes outside the catalogue answered `none of these` or `no gap`.
    pub outside: Share,
    /// Descriptions of what nothing explains that are right about the cause outside the catalogue.
    pub description: Share,
    /// Visible single effects that do not matter: nothing else was accused.
    pub immaterial: Share,
    /// Effects too weak to see of which nothing else was accused.
    pub weak: Share,
    /// Pairs of which both can be seen and matter, both named.
    pub pairs: Share,
    /// 90 % intervals of the shrinkage that hold the true one, for effects named rightly.
    pub coverage: Share,
    /// Widths of all intervals of the shrinkage.
    pub widths: Vec<f64>,
    /// Cases without a gap that were accused of one, by the noise that they have beside the white one.
    pub accused_by_noise: BTreeMap<String, Share>,
}

impl Scores {
    /// Members of the groups that were answered, on average; none where nothing was accused.
    pub fn group_size(&self) -> Option<f64> {
        (self.accusations > 0).then(|| self.named as f64 / self.accusations as f64)
    }

    /// Median width of the intervals of the shrinkage; none where there is none.
    pub fn width(&self) -> Option<f64> {
        (!self.widths.is_empty()).then(|| median(&mut self.widths.clone()))
    }

    /// Of both, as if they had been counted together.
    fn beside(mut self, other: &Self) -> Self {
        let shares = [
            (&mut self.false_accusations, other.false_accusations),
            (&mut self.top_1, other.top_1),
            (&mut self.in_group, other.in_group),
            (&mut self.outside, other.outside),
            (&mut self.description, other.description),
            (&mut self.immaterial, other.immaterial),
            (&mut self.weak, other.weak),
            (&mut self.pairs, other.pairs),
            (&mut self.coverage, other.coverage),
        ];
        shares.into_iter().for_each(|(own, other)| *own = own.beside(other));
        self.accusations += other.accusations;
        self.named += other.named;
        self.widths.extend(&other.widths);
        for (noise, share) in &other.accused_by_noise {
            let own = self.accused_by_noise.entry(noise.clone()).or_default();
            *own = own.beside(*share);
        }
        self
    }
}

/// How a batch is made again once its key is open: `challenge make --seed` with the same kinds and number of cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// Seed of its draws.
    pub seed: u64,
    /// Where they were drawn from.
    pub ground: Ground,
    /// Cycles of each test.
    pub cycles: i32,
    /// Its cases.
    pub ids: Vec<String>,
}

impl Batch {
    /// Of an open key.
    pub fn of(key: &Key) -> Self {
        let ids = key.cases.iter().map(|case| case.drawn.id.clone()).collect();
        Self { seed: key.seed, ground: key.ground, cycles: key.cycles, ids }
    }
}

/// Scores and the answers one by one, for the diagnosis and for the simple rules.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Table {
    /// What the cases were drawn with, as far as it was written down.
    #[serde(default)]
    pub batches: Vec<Batch>,
    /// The diagnosis.
    pub diagnosis: Scores,
    /// Of it the cases whose material is [`FAR`] off Table 1 or more.
    pub far: Scores,
    /// The simple rules, by name.
    pub rules: Vec<(String, Scores)>,
    /// Cases without an answer.
    pub missing: Vec<String>,
    /// Cases that are not counted.
    #[serde(default)]
    pub left_out: Vec<String>,
    /// Every answer.
    pub lines: Vec<Line>,
}

/// A case that is in both of two tables.
#[derive(Debug, thiserror::Error)]
#[error("case {0} is in both tables, so it would be counted twice")]
pub struct CountedTwice(String);

impl Table {
    /// What the confidences of all answers are worth.
    pub fn confidence(&self) -> Calibration {
        Calibration::of(self.lines.iter().map(|l| (l.confidence, l.right)).collect())
    }

    /// Of both tables, as if their cases had been scored together.
    ///
    /// # Errors
    /// Where a case is in both.
    pub fn beside(mut self, other: Self) -> Result<Self, CountedTwice> {
        let is_here = |l: &&Line| self.lines.iter().any(|own| own.id == l.id);
        if let Some(twice) = other.lines.iter().find(is_here) {
            return Err(CountedTwice(twice.id.clone()));
        }
        self.diagnosis = self.diagnosis.beside(&other.diagnosis);
        self.far = self.far.beside(&other.far);
        for (name, scores) in other.rules {
            match self.rules.iter_mut().find(|(own, _)| *own == name) {
                Some((_, own)) => *own = std::mem::take(own).beside(&scores),
                None => self.rules.push((name, scores)),
            }
        }
        self.batches.extend(other.batches);
        self.missing.extend(other.missing);
        self.left_out.extend(other.left_out);
        self.lines.extend(other.lines);
        Ok(self)
    }
}

/// An answer, of whichever method.
struct Answer {
    kind: Kind,
    families: Vec<String>,
    confidence: f64,
    /// Of the largest force (%), from which on a gap matters.
    matters_percent: f64,
    /// Value and interval claimed, and the true value.
    shrinkage: Option<(f64, f64, f64)>,
    true_shrinkage: Option<f64>,
    /// Whether what it tells of a cause outside the catalogue is right; none where it tells nothing, or nothing is outside.
    description: Option<bool>,
}

/// The table of cases and their answers, of one batch or of several.
pub fn score(batches: Vec<Batch>, cases: &[(Solution, Option<Diagnosis>)]) -> Table {
    let answered = || cases.iter().filter_map(|(s, d)| d.as_ref().map(|d| (s, d)));
    let missing = cases.iter().filter(|(_, d)| d.is_none()).map(|(s, _)| s.drawn.id.clone());
    let ours: Vec<(&Solution, Answer)> = answered().map(|(s, d)| (s, of_diagnosis(s, d))).collect();
    let lines = ours.iter().map(|(s, a)| line(s, a)).collect();
    let names: Vec<String> = answered()
        .next()
        .map(|(_, d)| d.simple_rules.iter().map(|r| r.rule.clone()).collect())
        .unwrap_or_default();
    let rules = names.into_iter().map(|name| {
        let of = |(s, d): (_, &Diagnosis)| {
            let rule = d.simple_rules.iter().find(|r| r.rule == name);
            let family = rule.and_then(|r| r.effect.clone());
            let kind = if family.is_some() { Kind::Effect } else { Kind::NoGap };
            let families = family.into_iter().collect();
            let matters_percent = d.verdict.matters_percent;
            let (shrinkage, true_shrinkage, description) = (None, None, None);
            (
                s,
                Answer {
                    kind,
                    families,
                    confidence: 1.0,
                    matters_percent,
                    shrinkage,
                    true_shrinkage,
                    description,
                },
            )
        };
        let answers: Vec<(&Solution, Answer)> = answered().map(of).collect();
        (name, scores(&answers))
    });
    let rules = rules.collect();
    let diagnosis = scores(&ours);
    let far: Vec<_> =
        ours.into_iter().filter(|(s, _)| factor_off_table_1(&s.drawn.material) >= FAR).collect();
    let (far, missing, left_out) = (scores(&far), missing.collect(), vec![]);
    Table { batches, diagnosis, far, rules, missing, left_out, lines }
}

fn of_diagnosis(solution: &Solution, d: &Diagnosis) -> Answer {
    let family = |name: &String| {
        let effect = d.effects.iter().find(|e| e.name == *name);
        effect.map_or_else(|| name.clone(), |e| e.family.clone())
    };
    let mut families: Vec<String> = d.verdict.effects.iter().map(family).collect();
    families.dedup();
    let claimed = d.shrinkage.as_ref();
    Answer {
        kind: d.verdict.kind,
        families,
        confidence: d.verdict.confidence,
        matters_percent: d.verdict.matters_percent,
        shrinkage: claimed.and_then(|s| Some((s.value?, s.interval?.0, s.interval?.1))),
        true_shrinkage: claimed.and_then(|s| {
            // Of these specimens, as far as data can tell them from the nominal one.
            let points = solution.truth_mn.first().map_or(0, Vec::len);
            let height = shared_height(&solution.drawn, points);
            let truth: Vec<f64> = solution.truth_mn.iter().flatten().map(|f| height * f).collect();
            s.against(&truth)
        }),
        description: (solution.drawn.kind == CaseKind::Outside && d.verdict.kind == Kind::NoneOfThese)
            .then(|| description::of(solution, d.leftover.as_ref()))
            .flatten(),
    }
}

/// Whether something was accused.
fn accuses(answer: &Answer) -> bool {
    matches!(answer.kind, Kind::Effect | Kind::Group | Kind::Pair)
}

/// Whether one effect was accused, or one of a group.
fn accuses_one(answer: &Answer) -> bool {
    matches!(answer.kind, Kind::Effect | Kind::Group)
}

fn is_right(solution: &Solution, answer: &Answer) -> bool {
    let names = |effect: &String| answer.families.contains(effect);
    match solution.drawn.kind {
        CaseKind::Null => answer.kind == Kind::NoGap,
        CaseKind::Outside => !accuses(answer),
        // A pair accuses one that is innocent.
        CaseKind::Single | CaseKind::Weak if accuses(answer) => {
            accuses_one(answer)
                && solution.effects.iter().all(names)
                && answer.families.len() <= LARGEST_GROUP
        }
        // To accuse nothing is right only of what cannot be seen, or does not matter.
        CaseKind::Single | CaseKind::Weak => !solution.matters(answer.matters_percent),
        CaseKind::Pair => {
            let found = solution.effects.iter().filter(|e| names(e)).count();
            // Of a pair of which one cannot be seen or does not matter, the other is a right answer.
            // One, and one of a group.
            let few = answer.families.len() <= 1 + LARGEST_GROUP;
            let both = solution.matters(answer.matters_percent);
            if both { found == 2 && few } else { !accuses(answer) || found > 0 }
        }
    }
}

fn scores(answers: &[(&Solution, Answer)]) -> Scores {
    let of = |kind: &'static [CaseKind]| answers.iter().filter(move |(s, _)| kind.contains(&s.drawn.kind));
    let single = || of(&[CaseKind::Single, CaseKind::Weak]);
    let matter = |(s, a): &&(&Solution, Answer)| s.matters(a.matters_percent);
    let visible = || single().filter(matter);
    let immaterial = single().filter(|pair| pair.0.is_visible() && !matter(pair));
    let weak = single().filter(|(s, _)| !s.is_visible());
    let first = |(s, a): &(&Solution, Answer)| accuses_one(a) && a.families.first() == s.effects.first();
    let accused: Vec<&Answer> = answers.iter().map(|(_, a)| a).filter(|a| accuses(a)).collect();
    let covered = |(s, a): &(&Solution, Answer)| {
        let ((_, low, high), truth) = (a.shrinkage?, a.true_shrinkage?);
        (s.is_visible() && a.families.first() == s.effects.first()).then_some(truth >= low && truth <= high)
    };
    let widths = answers.iter().filter_map(|(_, a)| a.shrinkage).map(|(_, low, high)| high - low);
    let mut accused_by_noise: BTreeMap<String, Share> = BTreeMap::new();
    for (s, a) in of(&[CaseKind::Null]) {
        let family = s.drawn.noise.family.name().to_owned();
        accused_by_noise.entry(family).or_default().count(a.kind != Kind::NoGap);
    }
    Scores {
        false_accusations: Share::of(of(&[CaseKind::Null]).map(|(_, a)| a.kind != Kind::NoGap)),
        top_1: Share::of(visible().map(first)),
        in_group: Share::of(visible().map(|(s, a)| is_right(s, a))),
        accusations: accused.len() as u64,
        named: accused.iter().map(|a| a.families.len() as u64).sum(),
        outside: Share::of(of(&[CaseKind::Outside]).map(|(_, a)| !accuses(a))),
        description: Share::of(answers.iter().filter_map(|(_, a)| a.description)),
        immaterial: Share::of(immaterial.map(|(s, a)| is_right(s, a))),
        weak: Share::of(weak.map(|(s, a)| is_right(s, a))),
        pairs: Share::of(of(&[CaseKind::Pair]).filter(matter).map(|(s, a)| is_right(s, a))),
        coverage: Share::of(answers.iter().filter_map(covered)),
        widths: widths.collect(),
        accused_by_noise,
    }
}

fn line(solution: &Solution, answer: &Answer) -> Line {
    let causes = solution.drawn.causes.iter().map(|c| c.effect().map_or_else(|| form(c), str::to_owned));
    let truth = causes.collect::<Vec<_>>().join(" + ");
    let kind = serde_json::to_value(answer.kind).ok();
    let kind = kind.as_ref().and_then(|k| k.as_str()).unwrap_or_default().to_owned();
    let families = answer.families.join(", ");
    Line {
        id: solution.drawn.id.clone(),
        truth: if truth.is_empty() { "nothing".to_owned() } else { truth },
        visibility: solution.visibility.iter().copied().min_by(f64::total_cmp),
        gap_percent: solution.gap_percent.iter().copied().min_by(f64::total_cmp),
        answer: if families.is_empty() { kind } else { format!("{kind}: {families}") },
        confidence: answer.confidence,
        right: is_right(solution, answer),
        shrinkage: answer.shrinkage,
        true_shrinkage: answer.true_shrinkage,
    }
}

/// Name of a form.
fn form(cause: &super::cause::Cause) -> String {
    let value = serde_json::to_value(cause).ok();
    let name = value.as_ref().and_then(|v| v["form"].as_str()).unwrap_or("unknown");
    format!("{name} (outside)")
}

#[cfg(test)]
mod tests {
    use super::super::draw::draw;
    use super::*;

    /// An answer to a visible single effect that matters: whether it is named first, and whether the answer is right.
    fn scored(kind: Kind, families: &[&str]) -> (u64, bool) {
        let drawn = draw(1, 1, &[CaseKind::Single], Ground::Wide).remove(0);
        let effects = vec!["offset".to_owned()];
        let solution =
            Solution { drawn, effects, visibility: vec![50.0], gap_percent: vec![3.0], truth_mn: vec![] };
        let answer = Answer {
            kind,
            families: families.iter().map(|f| (*f).to_owned()).collect(),
            confidence: 0.9,
            matters_percent: 1.0,
            shrinkage: None,
            true_shrinkage: None,
            description: None,
        };
        let right = is_right(&solution, &answer);
        (scores(&[(&solution, answer)]).top_1.hits, right)
    }

    #[test]
    fn a_single_effect_is_named_alone_or_in_a_group_not_in_a_pair() {
        assert_eq!(scored(Kind::Effect, &["offset"]), (1, true));
        assert_eq!(scored(Kind::Group, &["softening", "offset"]), (0, true));
        assert_eq!(scored(Kind::Group, &["offset", "slip", "softening", "eyring"]), (1, false));
        assert_eq!(scored(Kind::Pair, &["offset", "slip"]), (0, false));
        assert_eq!(scored(Kind::NoGap, &[]), (0, false));
    }
}
