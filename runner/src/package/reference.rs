//! What an importer may check itself with: parameters, experiment and result of the default run, as the layered standard
//! FMI-LS-REF (1.0.0-alpha.1) puts them into an archive.

use crate::fmi::{FmiError, ModelDescription};
use crate::parameter_set::ssv;
use crate::pool::Wiring;
use crate::pool::wiring::Names;
use poropunch::model_description::xml;
use poropunch::variables;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// Folder of the layered standard.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
const LAYER: &str = "org.fmi-standard.fmi-ls-ref";
/// SI units, one row per communication step; written by reference.py beside it.
const RESULT: &[u8] = include_bytes!("../../../cdylib/resources/reference.csv");
const PARAMETERS: &str = "table1.ssv";
const EXPERIMENTS: &str = "experiments.xml";
const RESULTS: &str = "P2.csv";

/// Names and contents of the files.
///
/// # Errors
/// When the model's own description cannot be read.
pub fn reference_files() -> Result<Vec<(String, Vec<u8>)>, FmiError> {
    let description = ModelDescription::parse(&xml())?;
    let parameters = Wiring::new(&description, &Names::default()).ok().map(|wiring| {
        let named = variables::identifiable().map(|(v, _)| v.name);
        let geometry =
            wiring.parameters.keys().map(String::as_str).filter(|name| name.starts_with("geometry."));
        let values = named
            .chain(geometry)
            .filter_map(|name| Some((name.to_owned(), wiring.parameters.get(name)?.start_number()?)));
        ssv("Table 1", &wiring, &values.collect())
    });
    let file = |name: &str, contents: Vec<u8>| (format!("{FOLDER}/{name}"), contents);
    Ok(vec![
        file("fmi-ls-manifest.xml", document(manifest)),
        file(EXPERIMENTS, document(|x| experiments(x, &description))),
        file(PARAMETERS, parameters.unwrap_or_default().into_bytes()),
        file(RESULTS, RESULT.to_vec()),
    ])
}

type Xml = Writer<Vec<u8>>;

fn document(write: impl Fn(&mut Xml) -> io::Result<()>) -> Vec<u8> {
    let mut x = Writer::new_with_indent(Vec::new(), b' ', 2);
    let declared = x.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    declared.and_then(|()| write(&mut x)).expect("writing to memory does not fail");
    x.into_inner()
}

fn manifest(x: &mut Xml) -> io::Result<()> {
    let root = x.create_element("fmiReferences").with_attributes([
        ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
        ("fmi-ls:fmi-ls-name", LAYER),
        ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1"),
        (
            "fmi-ls:fmi-ls-description",
            "Layered Standard providing information on related files included in an FMU.",
        ),
    ]);
    let related = [
        ("application/x-ssp-parameter-set", PARAMETERS, "parameter", "Material of the paper's Table 1"),
        ("application/xml", EXPERIMENTS, "experiment/smoke-test", "The default run: first cycle of P2"),
        ("text/csv", RESULTS, "result", "What the default run gives, SI units"),
    ];
    root.write_inner_content(|x| {
        for (kind, source, role, description) in related {
            let attributes =
                [("type", kind), ("source", source), ("role", role), ("description", description)];
            x.create_element("Related").with_attributes(attributes).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

fn experiments(x: &mut Xml, description: &ModelDescription) -> io::Result<()> {
    let run = description.default_experiment;
    let number = |value: Option<f64>| format!("{:?}", value.unwrap_or_default());
    let (start, stop, step) = (number(run.start_time), number(run.stop_time), number(run.step_size));
    x.create_element("Experiments").write_inner_content(|x| {
        let experiment = x.create_element("Experiment").with_attributes([
            ("name", "P2"),
            ("description", "First cycle of the built-in protocol P2 with the parameters of Table 1"),
            ("startTime", start.as_str()),
            ("stopTime", stop.as_str()),
            ("stepSize", step.as_str()),
        ]);
        experiment.write_inner_content(|x| {
            x.create_element("Parameters").with_attribute(("source", PARAMETERS)).write_empty()?;
            x.create_element("References").with_attribute(("source", RESULTS)).write_empty()?;
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}
