//! C. Steps: bad sizes, slicing of time, input semantics, failures with a reason.

use super::support::{
    check_bad_steps, choose_coarse, coarse, get, initialise, load, reference, running, running_p2, set,
};

#[test]
fn bad_steps_are_errors_and_reset_helps() {
    check_bad_steps(running, "fmi2DoStep");
}

#[test]
fn jitter_of_the_master_is_fine_but_not_a_step_past_the_stop_time() {
    let mut instance = coarse();
    initialise(&mut instance, Some(0.3));
    instance.do_step(0.0, 0.1).unwrap();
    instance.do_step(0.1 + 1e-12, 0.1).unwrap();
    instance.do_step(0.2, 0.1 + 1e-11).unwrap();
    let error = instance.do_step(0.3, 0.1).unwrap_err().to_string();
    assert!(error.contains("after the stop time 0.3 s"), "{error}");
}

#[test]
fn one_huge_step_equals_a_thousand_small_ones() {
    // Ramp (0.6875 s) and hold within one communication step: the corner is honoured by the FMU itself.
    let (mut huge, mut small) = (running_p2(), running_p2());
    huge.do_step(0.0, 5.0).unwrap();
    for n in 0..1000 {
        small.do_step(n as f64 * 5e-3, 5e-3).unwrap();
    }
    let (huge, small) = (get(&mut huge, "force"), get(&mut small, "force"));
    assert!((huge / small - 1.0).abs() < 1e-3, "{huge} against {small}");
}

#[test]
fn a_value_that_is_no_number_is_refused_and_the_old_one_stays() {
    let mut instance = running();
    set(&mut instance, "displacement", 1e-4);
    let input = [reference("displacement")];
    for bad in [f64::NAN, f64::INFINITY] {
        let error = instance.set_real(&input, &[bad]).unwrap_err().to_string();
        assert!(error.contains("displacement") && error.contains("not a finite number"), "{error}");
    }
    assert_eq!(get(&mut instance, "displacement"), 1e-4);
    instance.do_step(0.0, 0.1).unwrap();
    assert_eq!(get(&mut instance, "punch_displacement"), 1e-4);
}

#[test]
fn rate_and_derivative_make_the_same_ramp_as_the_displacement_ahead() {
    // Displacement at the start of the step plus rate, or the displacement at its end: one motion.
    let expected = load(&mut running(), 0.0, 0.125, 3);
    let (mut by_rate, mut by_derivative) = (running(), running());
    set(&mut by_rate, "displacement_rate", 1e-3);
    for (n, &force) in expected.iter().enumerate() {
        let time = n as f64 * 0.125;
        set(&mut by_rate, "displacement", 1e-3 * time);
        set(&mut by_derivative, "displacement", 1e-3 * time);
        by_derivative.set_input_derivatives(&[reference("displacement")], &[1], &[1e-3]).unwrap();
        for instance in [&mut by_rate, &mut by_derivative] {
            instance.do_step(time, 0.125).unwrap();
            assert_eq!(get(instance, "force").to_bits(), force);
        }
    }
}

#[test]
fn a_step_the_model_cannot_make_is_an_error_with_its_reason() {
    let mut instance = running();
    load(&mut instance, 0.0, 0.1, 2);
    set(&mut instance, "displacement", 0.5);
    let error = instance.do_step(0.2, 0.1).unwrap_err().to_string();
    assert!(error.contains("reaches the sample's height"), "{error}");
    set_and_recover(&mut instance);
}

fn set_and_recover(instance: &mut runner::fmi::FmuInstance) {
    let expected = load(&mut running(), 0.0, 0.1, 2);
    instance.reset().unwrap();
    choose_coarse(instance);
    initialise(instance, None);
    assert_eq!(load(instance, 0.0, 0.1, 2), expected);
}
