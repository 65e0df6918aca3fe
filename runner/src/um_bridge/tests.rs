//! The protocol over a force in closed form: mu t + alpha^2, mu and alpha those of the equilibrium response.

use super::{ForwardModel, Worker, answer};
use crate::fmi::ModelDescription;
use crate::pool::wiring::Names;
use crate::pool::{ForceCurve, Job, RunFailure, Simulator, Wiring};
use poropunch::motion::protocol::Protocol;
use serde_json::{Value, json};
use std::sync::Arc;

const MU: &str = "material.equilibrium.mu";
const ALPHA: &str = "material.equilibrium.alpha";

struct ClosedForm(Arc<Wiring>);

impl Simulator for ClosedForm {
    fn run(&mut self, job: &Job, _: &dyn Fn() -> bool) -> Result<ForceCurve, RunFailure> {
        let (mu, alpha) = (job.parameters[MU], job.parameters[ALPHA]);
        if alpha < -20.0 {
            return Err(RunFailure::Model("too nonlinear".to_owned()));
        }
        let mut values = vec![vec![0.0; job.time_s.len()]; self.0.outputs.len()];
        values[0] = job.time_s.iter().map(|t| mu * t + alpha * alpha).collect();
        if job.parameters.contains_key("solver.sensitivities") {
            values[self.0.sensitivities[MU]] = job.time_s.to_vec();
            values[self.0.sensitivities[ALPHA]] = vec![2.0 * alpha; job.time_s.len()];
        }
        Ok(ForceCurve { values, ..ForceCurve::default() })
    }
}

fn worker(parameters: &[&str]) -> Worker {
    let description = ModelDescription::parse(&poropunch::model_description::xml()).unwrap();
    let wiring = Wiring::new(&description, &Names { sensitivities: true, ..Names::default() }).unwrap();
    let wiring = Arc::new(wiring);
    let model = ForwardModel {
        wiring: Arc::clone(&wiring),
        parameters: parameters.iter().map(|&name| name.to_owned()).collect(),
        settings: [(MU.to_owned(), -100.0), (ALPHA.to_owned(), -2.0)].into(),
        protocol: Arc::new(Protocol::new(vec![(0.0, 0.0), (2.0, 1e-3)]).unwrap()),
        time_s: Arc::new([1.0, 2.0]),
    };
    Worker::over(&model, Box::new(ClosedForm(wiring)), &Arc::default())
}

fn ask(worker: &mut Worker, path: &str, mut body: Value) -> (u16, Value) {
    body["name"] = json!("force_mN");
    answer(worker, path, &body.to_string())
}

#[test]
fn force_gradient_and_jacobian() {
    let mut worker = worker(&[ALPHA, MU]);
    let input = json!([[-3.0, -10.0]]);
    let mut output = |path: &str, body: Value| ask(&mut worker, path, body).1["output"].clone();
    assert_eq!(output("/Evaluate", json!({ "input": input })), json!([[-1000.0, -11000.0]]));
    // J = [[2 alpha, t]] in the order of the inputs, in mN.
    let gradient =
        output("/Gradient", json!({ "input": input, "sens": [1.0, 0.5], "outWrt": 0, "inWrt": 0 }));
    assert_eq!(gradient, json!([-9000.0, 2000.0]));
    let along =
        output("/ApplyJacobian", json!({ "input": input, "vec": [1.0, 0.5], "outWrt": 0, "inWrt": 0 }));
    assert_eq!(along, json!([-5500.0, -5000.0]));
}

#[test]
fn sizes_and_support() {
    let mut one = worker(&[MU]);
    let (status, info) = answer(&mut one, "/Info", "");
    assert_eq!((status, info), (200, json!({ "protocolVersion": 1.0, "models": ["force_mN"] })));
    assert_eq!(ask(&mut one, "/InputSizes", json!({})).1, json!({ "inputSizes": [1] }));
    assert_eq!(ask(&mut one, "/OutputSizes", json!({ "config": {} })).1, json!({ "outputSizes": [2] }));
    assert_eq!(ask(&mut one, "/ModelInfo", json!({})).1["support"]["Gradient"], json!(true));
    let mut other = worker(&["geometry.punch_radius"]);
    assert_eq!(ask(&mut other, "/ModelInfo", json!({})).1["support"]["Gradient"], json!(false));
    let (status, refused) = ask(&mut other, "/Gradient", json!({ "input": [[2e-3]], "sens": [0.0, 0.0] }));
    assert_eq!((status, &refused["error"]["type"]), (400, &json!("UnsupportedFeature")));
}

#[test]
fn the_client_may_set_other_parameters() {
    let mut worker = worker(&[MU]);
    let mut force = |config: Value| {
        ask(&mut worker, "/Evaluate", json!({ "input": [[0.0]], "config": config })).1["output"][0][0].clone()
    };
    assert_eq!(force(json!({})), json!(4000.0));
    assert_eq!(force(json!({ ALPHA: -3 })), json!(9000.0));
    assert_eq!(force(json!({ ALPHA: "-3", "geometry.punch_radius": "1 mm" })), json!(9000.0));
}

#[test]
fn what_cannot_be_used_is_told() {
    let mut worker = worker(&[MU]);
    let mut told = |path: &str, body: &str| {
        let (status, value) = answer(&mut worker, path, body);
        let part = |name: &str| value["error"][name].as_str().unwrap().to_owned();
        (status, part("type"), part("message"))
    };
    let body = |rest: &str| format!(r#"{{"name": "force_mN", {rest}}}"#);
    for (path, body, status, kind, part) in [
        ("/Nothing", "{}".to_owned(), 404, "NotFound", "Evaluate"),
        ("/Evaluate", "not JSON".to_owned(), 400, "InvalidInput", "the body"),
        ("/Evaluate", r#"{"name": "posterior"}"#.to_owned(), 400, "ModelNotFound", "force_mN"),
        ("/Evaluate", body(r#""input": [[1.0, 2.0]]"#), 400, "InvalidInput", MU),
        ("/Evaluate", body(r#""input": []"#), 400, "InvalidInput", "one input"),
        (
            "/Evaluate",
            body(r#""input": [[0.0]], "config": {"material.n0s": 7}"#),
            400,
            "InvalidInput",
            "bounds",
        ),
        (
            "/Evaluate",
            body(r#""input": [[0.0]], "config": {"material.n0x": 7}"#),
            400,
            "InvalidInput",
            "did you mean",
        ),
        (
            "/Evaluate",
            body(r#""input": [[0.0]], "config": {"material.n0s": []}"#),
            400,
            "InvalidInput",
            "number",
        ),
        (
            "/Evaluate",
            body(&format!(r#""input": [[0.0]], "config": {{"{ALPHA}": -25}}"#)),
            500,
            "ModelError",
            "nonlinear",
        ),
        ("/Gradient", body(r#""input": [[0.0]], "sens": [1.0]"#), 400, "InvalidInput", "give 2"),
        ("/ApplyJacobian", body(r#""input": [[0.0]], "vec": []"#), 400, "InvalidInput", "give 1"),
        (
            "/Gradient",
            body(r#""input": [[0.0]], "sens": [1.0, 1.0], "inWrt": 1"#),
            400,
            "InvalidInput",
            "number 0",
        ),
    ] {
        let (found, type_, message) = told(path, &body);
        assert!(
            (found, type_.as_str()) == (status, kind) && message.contains(part),
            "{body}: {found} {type_} {message}"
        );
    }
}
