//! `documentation/index.html` of the archive, from the variable table.

use poropunch::fields::QUANTITIES;
use poropunch::variables::{Causality, Kind, Value, Variable, table};

const STYLE: &str = "body{font:15px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em}\
    table{border-collapse:collapse;width:100%}td,th{border-bottom:1px solid #ccc;padding:.25em .6em;\
    text-align:left;vertical-align:top}code,pre{background:#f4f4f4}pre{padding:1em;overflow:auto}";

const USE: &str = r#"<h2>Use from FMPy</h2>
<pre>from fmpy import simulate_fmu

result = simulate_fmu(
    "poropunch.fmu", stop_time=10.0, output_interval=0.0625,
    start_values={"material.permeability": 1e-15},
    output=["punch_displacement", "force", "force_fluid"])
print(result["force"].max())
</pre>
<p>Without any setting the punch follows the built-in protocol, whose corner lies on this grid. Masters that cannot
set enumerations set the integers of the same names with <code>_number</code>; 0 leaves them as they are.</p>
<h2>Your own displacement: mind the input hold</h2>
<p>Set <code>protocol.source</code> to 1 (inputs): otherwise setting the inputs is an error. Most masters set the inputs at the <em>start</em> of a step and then step. If only
<code>displacement</code> is given, the punch lags by one communication step: on protocol P2 the force is
off by up to 17 % of its peak with steps of 0.1 s, and 6 % with steps of 0.01 s. Three ways avoid it, all exact:</p>
<ol>
<li><code>protocol.source = trapezoid</code>, the default: the FMU makes the test itself, with exact corners.</li>
<li>Give the input <code>displacement_rate</code> too, the slope of the displacement during the next
step. It is discrete, so FMPy makes a communication point at each of its jumps: the corners stay exact.
A CSV then has the columns <code>time,displacement,displacement_rate</code>.</li>
<li>Masters with input derivatives call <code>fmi2SetRealInputDerivatives</code> (order 1).</li>
</ol>
<p>Within a step the punch moves at constant velocity from where it is to
<code>displacement + rate &middot; step</code>. The model steps by itself inside a communication step;
its size need not follow the physics.</p>
"#;

/// The whole page.
pub fn documentation() -> String {
    let section = |title: &str, causality: Causality| {
        let rows: String = table().iter().filter(|v| v.causality == causality).map(row).collect();
        format!(
            "<h2>{title}</h2>\n<table><tr><th>name</th><th>start</th><th>range</th><th>unit (shown as)</th>\
             <th>meaning</th></tr>\n{rows}</table>\n"
        )
    };
    let sections = section("Inputs", Causality::Input)
        + &section("Outputs", Causality::Output)
        + &section("Parameters", Causality::Parameter);
    page(USE, &(fields() + &sections))
}

/// A page: how the FMU is used, and tables.
pub(super) fn page(usage: &str, tables: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>poropunch</title>\
         <style>{STYLE}</style></head><body>\n<h1>poropunch {}</h1>\n\
         <p>A flat cylindrical punch is pressed into a soft, water-saturated disc: finite-strain biphasic \
         theory, Ogden equilibrium, viscous branches, Darcy flow. SI units; displacement and force are \
         positive into the sample. A branch with <code>mu = 0</code> is absent. The punch may \
         retract and touch again; it never pulls at the sample.</p>\n{usage}{tables}</body></html>\n",
        env!("CARGO_PKG_VERSION"),
    )
}

/// What a series of fields holds.
pub(super) fn fields() -> String {
    let row = |q: &poropunch::fields::Quantity| {
        format!("<tr><td><code>{}</code></td><td>{}</td><td>{}</td></tr>\n", q.name, q.unit, q.description)
    };
    let rows: String = QUANTITIES.iter().map(row).collect();
    format!(
        "<h2>Fields for ParaView</h2>\n<p>The parameter <code>fields.path</code>, in FMPy \
         <code>start_values={{\"fields.path\": \"fields/P2.pvd\"}}</code>, makes the FMU write a series of VTU files \
         with its .pvd while it runs. Points are (r, 0, z), z upwards from the bottom of the sample; Warp By \
         Vector takes <code>displacement_m</code>.</p>\n\
         <table><tr><th>array</th><th>unit</th><th>meaning</th></tr>\n{rows}</table>\n"
    )
}

/// A variable's start value, range and unit, for people.
pub(super) fn start(variable: &Variable) -> (String, String, String) {
    let (range, unit) = match variable.kind {
        Kind::Real { unit, range } => {
            let shown = if unit.display == unit.symbol {
                unit.symbol.to_owned()
            } else {
                format!("{} ({})", unit.symbol, unit.display)
            };
            (range.map(|(min, max)| format!("{min:?} to {max:?}")).unwrap_or_default(), shown)
        }
        Kind::Integer { range } => {
            (range.map(|(min, max)| format!("{min} to {max}")).unwrap_or_default(), String::new())
        }
        Kind::Boolean => ("true, false".to_owned(), String::new()),
        Kind::Text => ("text".to_owned(), String::new()),
        Kind::Enumeration(e) => {
            let items = e.items.iter().zip(1..).map(|((name, _), value)| format!("{value} {name}"));
            (items.collect::<Vec<_>>().join(", "), String::new())
        }
    };
    let start = match (variable.causality, variable.start()) {
        (Causality::Output, _) => String::new(),
        (_, Value::Real(v)) => format!("{v:?}"),
        (_, Value::Integer(v)) => v.to_string(),
        (_, Value::Boolean(v)) => v.to_string(),
        (_, Value::Text(v)) => format!("\"{v}\""),
        (_, Value::Count(v)) => v.to_string(),
    };
    (start, range, unit)
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn row(variable: &Variable) -> String {
    let (start, range, unit) = start(variable);
    format!(
        "<tr><td><code>{}</code></td><td>{start}</td><td>{range}</td><td>{unit}</td><td>{}</td></tr>\n",
        escape(variable.name),
        escape(variable.description)
    )
}
