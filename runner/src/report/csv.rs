//! The report as tables for other programs.

use super::fit_report::*;
use std::fmt::Write;

/// Free, fixed and derived quantities, one per line: `parameters.csv`.
pub fn parameters_csv(report: &FitReport) -> String {
    let mut out = String::from("kind,name,symbol,unit,value,lower95,upper95,determination,at_bound,start\n");
    for p in &report.parameters {
        let bound = p.at_bound.map_or(String::new(), |b| format!("{b:?}").to_lowercase());
        line(
            &mut out,
            &[
                "free".to_owned(),
                p.name.clone(),
                p.symbol.clone(),
                p.unit.clone(),
                number(p.value),
                number(p.lower),
                number(p.upper),
                format!("{:?}", p.determination).to_lowercase(),
                bound,
                number(p.start),
            ],
        );
    }
    let blank = String::new;
    for f in &report.fixed {
        let kind = if f.how == "fixed" { "fixed" } else { "tied" };
        let mut cells =
            vec![kind.to_owned(), f.name.clone(), f.symbol.clone(), f.unit.clone(), number(f.value)];
        cells.resize_with(10, blank);
        line(&mut out, &cells);
    }
    for d in &report.derived {
        line(
            &mut out,
            &[
                "derived".to_owned(),
                d.name.clone(),
                d.symbol.clone(),
                d.unit.clone(),
                number(d.value),
                number(d.lower),
                number(d.upper),
                format!("{:?}", d.determination).to_lowercase(),
                blank(),
                blank(),
            ],
        );
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
        let role = match m.role {
            Role::Fit => "fit",
            Role::Validation => "validation",
        };
        let optional = |v: &Option<Vec<f64>>, i: usize| v.as_ref().map_or(String::new(), |v| number(v[i]));
        for i in 0..m.time_s.len() {
            line(
                &mut out,
                &[
                    m.name.clone(),
                    role.to_owned(),
                    number(m.time_s[i]),
                    number(m.displacement_mm[i]),
                    number(m.measured_mn[i]),
                    optional(&m.spread_mn, i),
                    m.sigma_mn.get(i).map_or(String::new(), |&s| number(s)),
                    number(m.model_mn[i]),
                    optional(&m.model_solid_mn, i),
                    optional(&m.model_fluid_mn, i),
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
