//! The inspection as tables for other programs.

use super::result::*;
use crate::data::{Estimate, Quartiles};

/// One line per test and cycle: `cycles.csv`.
pub fn cycles_csv(inspection: &Inspection) -> String {
    let mut out = String::from(
        "test,cycle,start_s,ramp_start_s,ramp_end_s,hold_end_s,surface_s,withdrawn_s,end_s,depth_mm,rate_mm_per_s,\
         specimens,peak_mN,peak_q25_mN,peak_q75_mN,force_1s_mN,force_10s_mN,force_30s_mN,force_90s_mN,\
         hold_end_mN,hold_end_q25_mN,hold_end_q75_mN,relaxation_percent,relaxation_q25_percent,\
         relaxation_q75_percent,peak_over_first,retraction_minimum_mN,noise_alone_mN,off_contact_before_mN,\
         off_contact_after_mN,drift_mN,drift_sigma_mN,contact_threshold_mm,contact_threshold_sigma_mm,\
         contact_onset_mm,contact_onset_sigma_mm\n",
    );
    for test in &inspection.tests {
        for c in &test.cycles {
            let quartiles = |q: Quartiles| [Some(q.median), Some(q.q25), Some(q.q75)];
            let after = |s: f64| c.force_after.iter().find(|f| f.after_s == s).map(|f| f.force_mn.median);
            let value = |e: Option<Estimate>| e.map(|e| e.value);
            let mut cells = vec![
                Some(c.times.start_s),
                Some(c.times.ramp_start_s),
                Some(c.times.ramp_end_s),
                Some(c.times.hold_end_s),
            ];
            cells.extend([c.times.surface_s, c.times.withdrawn_s, Some(c.times.end_s), Some(c.depth_mm)]);
            cells.extend([Some(c.rate_mm_per_s.value), Some(c.peak_mn.count as f64)]);
            cells.extend(quartiles(c.peak_mn));
            cells.extend([1.0, 10.0, 30.0, 90.0].map(after));
            cells.extend(quartiles(c.hold_end_mn));
            cells.extend(quartiles(c.relaxation_percent));
            cells.push(Some(c.peak_over_first.median));
            cells.extend([c.retraction.map(|r| r.minimum_mn.median), c.retraction.map(|r| r.noise_alone_mn)]);
            cells.extend([
                value(c.off_contact.off_contact_before_mn),
                value(c.off_contact.off_contact_after_mn),
            ]);
            cells.extend([value(c.off_contact.drift_mn), c.off_contact.drift_mn.map(|d| d.sigma)]);
            let contact = c.contact.as_ref();
            cells.extend([contact.map(|k| k.threshold_mm.median), contact.map(|k| k.threshold_sigma_mm)]);
            cells.extend([
                contact.and_then(|k| k.onset_mm).map(|q| q.median),
                contact.and_then(|k| k.onset_sigma_mm),
            ]);
            let cells: Vec<String> = cells.into_iter().map(|v| v.map_or_else(String::new, number)).collect();
            out.push_str(&format!("{},{},{}\n", quoted(&test.name), c.times.number, cells.join(",")));
        }
    }
    out
}

/// Every point with its cycle and phase: `phases.csv`.
pub fn phases_csv(inspection: &Inspection) -> String {
    let mut out =
        String::from("test,time_s,displacement_mm,force_mN,force_q25_mN,force_q75_mN,cycle,phase\n");
    for test in &inspection.tests {
        let c = &test.curve;
        for i in 0..c.time_s.len() {
            let quartiles = c
                .quartiles_mn
                .as_ref()
                .map_or_else(|| ",".to_owned(), |q| format!("{},{}", number(q[i].0), number(q[i].1)));
            out.push_str(&format!(
                "{},{},{},{},{quartiles},{},{}\n",
                quoted(&test.name),
                number(c.time_s[i]),
                number(c.displacement_mm[i]),
                number(c.force_mn[i]),
                c.cycle[i],
                c.phase[i].name()
            ));
        }
    }
    out
}

/// Eight significant digits: more than any measurement, few enough to hide 0.1 + 0.2.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.7e}").parse().unwrap_or(value);
    format!("{rounded}")
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
