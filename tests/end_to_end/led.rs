//! Fits that a rougher model leads.

use super::program::repository;
use runner::data::reader::{Wanted, read};
use runner::diagnosis::plain_start::PlainStarts;
use runner::engine::{Engine, EngineOptions};
use runner::inference::fit::{End, chi_squares, fit, foreseen_end};
use runner::inference::rough::{Trust, Twin, coarser_at};
use runner::inference::{Depth, Fit, FitPlan, Requests, Setup, Unknowns, noise_at};
use runner::noise::Weights;
use runner::noise::observation::observe;
use runner::pool::wiring::Names;

fn engine() -> Engine {
    let names = Names { sensitivities: true, ..Names::default() };
    Engine::new(&EngineOptions { names, ..EngineOptions::default() }).unwrap()
}

/// Goal: where a rougher model leads to what the model asked for cannot compute, the fit goes on from the last point of that way which it can.
/// Set-up: practice data with two cycles, whose first start leads to a stiff fast branch that the coarse mesh cannot unload. Criterion: the end
/// can be computed, and chi^2 there is less than half of that at the start.
#[test]
fn a_fit_that_is_led_astray_goes_back() {
    let read = |name: &str| {
        read(&repository(&format!("data/practice/retraction/{name}.csv")), Wanted::MotionAndForce)
    };
    let observations = observe(&["P1", "P2"].map(|name| read(name).unwrap()), None).unwrap();
    let engine = engine();
    let requests = Requests { set: vec!["mesh.preset=coarse".to_owned()], ..Requests::default() };
    let PlainStarts { unknowns, .. } = PlainStarts::of(&engine, &observations, &requests).unwrap();
    let setup = Setup::new(&engine, &observations, &unknowns);
    let start = unknowns.start();
    let covariance = noise_at(setup, start, &Weights::default(), false).unwrap().covariance;
    let (end, _) = foreseen_end(setup, &covariance, (start, 40), &mut |_| {}).unwrap();
    let points = [start.to_vec(), end];
    let [before, after] = chi_squares(setup, &[], &covariance, &points).unwrap()[..] else { unreachable!() };
    assert!(after.unwrap() < 0.5 * before.unwrap(), "{after:?} of {before:?}");
}

/// Goal: a rougher model shortens the way to a minimum and does not move it. Set-up: P2 of the lagging practice data, whose gap leaves
/// the fit far from its start; the steps' tolerance, given as a setting at its own value, turns the rougher model off. Criterion: chi^2 within 0.5
/// of some thousand, forces within 2 % of the gap.
#[test]
fn a_fit_that_is_led_ends_where_the_other_one_does() {
    let file = repository("data/practice/lag/P2.csv");
    let observations = observe(&[read(&file, Wanted::MotionAndForce).unwrap()], None).unwrap();
    let engine = engine();
    let tolerance = poropunch::variables::by_name("solver.tolerance").unwrap().1.start_number();
    let fitted = |set: Vec<String>, is_led: bool| -> Fit {
        let requests = Requests { set, ..Requests::default() };
        let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests).unwrap();
        let setup = Setup::new(&engine, &observations, &unknowns);
        assert_eq!(Twin::leading(setup, &[]).is_some(), is_led);
        let start = unknowns.start().to_vec();
        let noise = noise_at(setup, &start, &Weights::default(), false).unwrap();
        fit(setup, &[], &noise.covariance, &FitPlan::to_minimum(&start, 40), &mut |_| {}).unwrap()
    };
    let coarse = "mesh.preset=coarse".to_owned();
    let led = fitted(vec![coarse.clone()], true);
    let alone = fitted(vec![coarse, format!("solver.tolerance={tolerance}")], false);
    let (chi_square, other) = (led.solution.chi_square, alone.solution.chi_square);
    assert!(other > 500.0 && (chi_square - other).abs() < 0.5, "{chi_square} and {other}");
    let apart = (&led.gap_mn - &alone.gap_mn).amax();
    let gap = alone.gap_mn.amax();
    assert!(apart < 0.02 * gap, "{apart} of {gap} mN");
}

/// Goal: what stands for the model asked for gives what that gives where it was corrected. Set-up: P2 of the lagging practice data, roughly
/// fitted: with the coarse mesh by the rougher model that leads, with the standard one by the coarse one beside it. Criterion: the same chi^2 of
/// the model asked for, and none stands for the coarsest but the one that leads; with more trust in that one there are fewer evaluations.
#[test]
fn what_stands_for_the_model_agrees_with_it() {
    let file = repository("data/practice/lag/P2.csv");
    let observations = observe(&[read(&file, Wanted::MotionAndForce).unwrap()], None).unwrap();
    let engine = engine();
    let fitted = |mesh: &str, depth: Depth, trust: Trust| {
        let requests = Requests { set: vec![format!("mesh.preset={mesh}")], ..Requests::default() };
        let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests).unwrap();
        let setup = Setup::new(&engine, &observations, &unknowns);
        let start = unknowns.start().to_vec();
        let covariance = noise_at(setup, &start, &Weights::default(), false).unwrap().covariance;
        let plan = FitPlan { start, evaluations: if depth == Depth::Rough { 1 } else { 40 }, depth, trust };
        let fit = fit(setup, &[], &covariance, &plan, &mut |_| {}).unwrap();
        let coarser = coarser_at(setup, &[], &fit).unwrap();
        let chi_square = |setup: Setup| {
            chi_squares(setup, &[], &covariance, std::slice::from_ref(&fit.solution.x)).unwrap()[0].unwrap()
        };
        let beside = coarser.as_ref().map(|coarser| chi_square(coarser.setup(setup)));
        (fit.end, fit.solution.evaluations, fit.solution.chi_square, chi_square(setup), beside)
    };
    // No rough fit has less than nothing.
    let led = [Trust { foreseen: 1e-6, ..Trust::LITTLE }, Trust::MUCH].map(|trust| {
        let (end, evaluations, by_rougher, asked, beside) = fitted("coarse", Depth::Below(0.0), trust);
        assert_eq!((end, beside), (End::RougherModel, None));
        assert!((by_rougher - asked).abs() < 1e-6 * asked, "{by_rougher} and {asked}");
        (evaluations, asked)
    });
    let [(closely, least), (roughly, chi_square)] = led;
    assert!(roughly < closely && chi_square < 1.1 * least, "{led:?}");
    let (end, .., asked, beside) = fitted("standard", Depth::Rough, Trust::LITTLE);
    assert_eq!(end, End::Rough);
    assert!((beside.unwrap() - asked).abs() < 1e-6 * asked, "{beside:?} and {asked}");
}
