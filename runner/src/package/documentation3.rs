//! `documentation/index.html` of the FMI 3.0 archive, from the same variable table.

use super::documentation::{escape, fields, page, start};
use poropunch::variables::ports::{POINTS, Port};
use poropunch::variables::{Causality, Kind};

const USE: &str = r#"<h2>Use from FMPy</h2>
<pre>from fmpy import simulate_fmu

result = simulate_fmu(
    "poropunch-fmi3.fmu", stop_time=10.0, output_interval=0.1,
    start_values={"material.permeability": 1e-15}, output=["punch_displacement", "force"],
    use_event_mode=True, early_return_allowed=True)
print(result["force"].max())
</pre>
<p>With early return, steps end at the corners of the motion and where contact is made or lost, whatever the output
interval: no peak is missed. With event mode too, these are events, and the next corner is the next event time.</p>
<h2>Arrays</h2>
<p><code>material.branch.mu</code>, <code>.alpha</code>, <code>.eta</code> have one element for each viscous branch; 
<code>mu = 0</code> switches a branch off. <code>sensitivity.matrix</code> holds all derivatives of the forces by the material.</p>
<h2>Your own displacement</h2>
<ol>
<li>As parameters: set <code>protocol.points</code> in configuration mode, then <code>protocol.history.time</code> and
<code>protocol.history.displacement</code>. The corners are exact, and events.</li>
<li>As inputs: set <code>protocol.source</code> to 1 (inputs) and give <code>displacement</code> and the discrete
<code>displacement_rate</code>, which may jump in event mode: within a step the punch moves at constant velocity from
where it is to <code>displacement + rate &middot; step</code>.</li>
<li>With intermediate update and <code>displacement</code> among the intermediate variables, the FMU asks for the
displacement at the end of each step: no lag, without any rate.</li>
</ol>
"#;

/// The whole page.
pub fn documentation3() -> String {
    let section = |title: &str, causality: Causality| {
        let rows: String = Port::all().filter(|port| port.causality() == causality).map(row).collect();
        format!(
            "<h2>{title}</h2>\n<table><tr><th>name</th><th>elements</th><th>start</th><th>range</th>\
             <th>unit (shown as)</th><th>meaning</th></tr>\n{rows}</table>\n"
        )
    };
    let sections =
        [("Inputs", Causality::Input), ("Outputs", Causality::Output), ("Parameters", Causality::Parameter)];
    let sections: String = sections.into_iter().map(|(title, causality)| section(title, causality)).collect();
    page(USE, &(fields() + &sections))
}

fn row(port: Port) -> String {
    let elements = match (port.shape().as_slice(), port.is_history()) {
        (_, true) => POINTS.to_owned(),
        (shape, _) => shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" &times; "),
    };
    let (start, range, unit) = port.variable().map(start).unwrap_or_default();
    let unit = match (port, port.variable().map(|variable| variable.kind)) {
        (Port::Time | Port::HistoryTime, _) => "s".to_owned(),
        (Port::HistoryDisplacement, _) => "m (mm)".to_owned(),
        (_, Some(Kind::Real { .. })) => unit,
        _ => String::new(),
    };
    let (name, meaning) = (escape(&port.name()), escape(&port.description()));
    format!(
        "<tr><td><code>{name}</code></td><td>{elements}</td><td>{start}</td><td>{range}</td><td>{unit}</td>\
         <td>{meaning}</td></tr>\n"
    )
}
