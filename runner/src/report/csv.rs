//! The report as tables for other programs.

use super::fit_report::*;
use std::fmt::Write;

/// Free, fixed and derived quantities, one per line: `parameters.csv`.
pub fn parameters_csv(report: &FitReport) -> String {
    let mut out = String::from("kind,name,symbol,unit,value,lower95,upper95,determination,at_bound,start\n");
    // What a kind does not have at its end is left empty.
    let mut row = |texts: [&str; 4], value: f64, known: Vec<String>| {
        let mut cells: Vec<String> = texts.map(str::to_owned).into();
        cells.push(number(value));
        cells.extend(known);
        cells.resize_with(10, String::new);
        line(&mut out, &cells);
    };
    let word = |w: &dyn std::fmt::Debug| format!("{w:?}").to_lowercase();
    for p in &report.parameters {
        let bound = p.at_bound.map_or_else(String::new, |b| word(&b));
        let known = vec![number(p.lower), number(p.upper), word(&p.determination), bound, number(p.start)];
        row(["free", &p.name, &p.symbol, &p.unit], p.value, known);
    }
    for f in &report.given.fixed {
        let kind = if f.how == "fixed" { "fixed" } else { "tied" };
        row([kind, &f.name, &f.symbol, &f.unit], f.value, vec![]);
    }
    for d in &report.derived {
        let known = vec![number(d.lower), number(d.upper), word(&d.determination)];
        row(["derived", &d.name, &d.symbol, &d.unit], d.value, known);
    }
    out
}

/// Measured and modelled forces of all measurements, one point per line: `curves.csv`.
pub fn curves_csv(report: &FitReport) -> String {
    let mut out = String::from(
        "measurement,role,time_s,displacement_mm,measured_mN,spread_mN,sigma_mN,model_mN,model_solid_mN,\
         model_fluid_mN\n",
    );
    for m in &report.measurements {
        let role = match m.curve.role {
            Role::Fit => "fit",
            Role::Validation => "validation",
        };
        let optional = |v: &Option<Vec<f64>>, i: usize| v.as_ref().map_or(String::new(), |v| number(v[i]));
        for i in 0..m.curve.time_s.len() {
            line(
                &mut out,
                &[
                    m.curve.name.clone(),
                    role.to_owned(),
                    number(m.curve.time_s[i]),
                    number(m.curve.displacement_mm[i]),
                    number(m.curve.measured_mn[i]),
                    optional(&m.curve.spread_mn, i),
                    m.curve.sigma_mn.get(i).map_or(String::new(), |&s| number(s)),
                    number(m.curve.model_mn[i]),
                    optional(&m.curve.model_solid_mn, i),
                    optional(&m.curve.model_fluid_mn, i),
                ],
            );
        }
    }
    out
}

fn number(value: f64) -> String {
    // Nine digits: more than any measurement, few enough to hide 0.1 + 0.2.
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

fn line(out: &mut String, cells: &[String]) {
    let quoted: Vec<String> =
        cells
            .iter()
            .map(|c| {
                if c.contains([',', '"', '\n']) {
                    format!("\"{}\"", c.replace('"', "\"\""))
                } else {
                    c.clone()
                }
            })
            .collect();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{}", quoted.join(","));
}
