//! Fields of uniform states, known in closed form, and of a run.

use super::*;
use crate::element::AssemblyMap;
use crate::element::geometry::Geometry;
use crate::element::undeformed;
use crate::law::PointMaterial;
use crate::law::parameters::{MaterialParameters, OgdenParameters};
use crate::mesh::Mesh;
use crate::mesh::parameters::{MeshKind, MeshPreset};
use crate::{Instance, Model, Parameters};
use approx::assert_relative_eq;

/// A block with the displacement (u_r, u_z) and the pressure as functions of (R, Z), its history undeformed.
fn block(
    material: &MaterialParameters,
    displacement: impl Fn(f64, f64) -> [f64; 2],
    pressure: impl Fn(f64, f64) -> f64,
) -> Fields {
    let mesh = Mesh::tensor(&[0.0, 0.4e-3, 1e-3, 2e-3], &[0.0, 0.3e-3, 1e-3], 1e-3);
    let mut x = vec![0.0; mesh.unknowns()];
    for (node, &[r, z]) in mesh.nodes.iter().enumerate() {
        let unknown = mesh.displacement(node as u32);
        x[unknown..unknown + 2].copy_from_slice(&displacement(r, z));
        if let Some(unknown) = mesh.pressure(node as u32) {
            x[unknown] = pressure(r, z);
        }
    }
    let touched: Vec<u32> = mesh.punch().collect();
    extract(&FieldSource {
        geometry: &Geometry::new(&mesh),
        map: &AssemblyMap::new(&mesh),
        material: &PointMaterial::new(material),
        history: &undeformed(mesh.elements.len(), material.branches.len()),
        mesh: &mesh,
        x: &x,
        touched: &touched,
    })
    .unwrap()
}

/// Demands one value of a quantity everywhere, at points and in cells.
fn is_uniform(fields: &Fields, name: &str, expected: &[f64]) {
    let everywhere = [fields.at_points(name), fields.in_cells(name)];
    assert!(everywhere.iter().any(Option::is_some), "{name}");
    // The floor is far below anything that is not rounding.
    let scale = expected.iter().fold(1e-20_f64, |m, v| m.max(v.abs()));
    for field in everywhere.into_iter().flatten() {
        for value in field.values.chunks(field.quantity.components.len()) {
            assert_eq!(value.len(), expected.len(), "{name}");
            for (value, expected) in value.iter().zip(expected) {
                assert!((value - expected).abs() <= 1e-9 * scale, "{name}: {value} instead of {expected}");
            }
        }
    }
}

/// Principal Kirchhoff stress of an Ogden term (Eq. 8) with volume-preserving stretches (Pa).
fn ogden(p: &OgdenParameters, stretches: [f64; 3]) -> [f64; 3] {
    let powers = stretches.map(|l| l.powf(p.alpha));
    let mean = powers.iter().sum::<f64>() / 3.0;
    powers.map(|power| p.mu * (power - mean))
}

#[test]
fn uniform_compression_in_closed_form() {
    let (radial, axial, p) = (1.07, 0.8, 500.0);
    let material = MaterialParameters { n0s: 0.2, ..MaterialParameters::default() };
    let fields = block(&material, |r, z| [(radial - 1.0) * r, (axial - 1.0) * z], |_, _| p);

    let j = radial * radial * axial;
    is_uniform(&fields, "jacobian", &[j]);
    is_uniform(&fields, "solid_fraction", &[0.2 / j]);
    is_uniform(&fields, "porosity", &[1.0 - 0.2 / j]);
    is_uniform(&fields, "vertical_stretch", &[axial]);
    is_uniform(&fields, "pore_pressure_Pa", &[p]);
    is_uniform(&fields, "porous_dissipation_W_per_m3", &[0.0]);

    // The history is undeformed: the branches carry the whole strain (Eq. 9) and dissipate (Eq. 13).
    let stretches = [radial, axial, radial].map(|l| l / j.cbrt());
    let s = 1.0 - 0.2;
    let mut tau = [material.lambda_star * s * s * (j / s - j / (j - 0.2)); 3];
    let mut dissipation = 0.0;
    for (a, beta) in ogden(&material.equilibrium, stretches).into_iter().enumerate() {
        tau[a] += beta;
    }
    for branch in &material.branches {
        for (a, beta) in ogden(&branch.ogden, stretches).into_iter().enumerate() {
            tau[a] += beta;
            dissipation += beta * beta / (2.0 * branch.eta);
        }
    }
    let effective = [tau[0] / j, tau[1] / j, tau[2] / j, 0.0];
    is_uniform(&fields, "stress_effective_Pa", &effective);
    is_uniform(&fields, "stress_total_Pa", &[effective[0] - p, effective[1] - p, effective[2] - p, 0.0]);
    is_uniform(&fields, "viscous_dissipation_W_per_m3", &[dissipation]);

    for (index, &[r, y, z]) in fields.points.iter().enumerate() {
        let u = fields.at_points("displacement_m").unwrap().row(index);
        assert_eq!(y, 0.0);
        assert_relative_eq!(u[0], (radial - 1.0) * r, epsilon = 1e-15);
        assert_eq!(u[1], 0.0);
        assert_relative_eq!(u[2], (axial - 1.0) * z, epsilon = 1e-15);
        let under_punch = r <= 1e-3 && z >= 1e-3;
        assert_eq!(fields.at_points("contact").unwrap().row(index), [f64::from(u8::from(under_punch))]);
    }
    let volume: f64 = fields.in_cells("undeformed_volume_m3").unwrap().values.iter().sum();
    assert_relative_eq!(volume, std::f64::consts::PI * 2e-3 * 2e-3 * 1e-3, max_relative = 1e-12);
}

/// `u_z = g R`: a neo-Hookean solid (alpha = 2) carries the shear stress mu g, rz and not zr.
#[test]
fn shear_stress_in_closed_form() {
    let equilibrium = OgdenParameters { mu: 300.0, alpha: 2.0 };
    let material = MaterialParameters { equilibrium, branches: Vec::new(), ..MaterialParameters::default() };
    let g = 0.3;
    let fields = block(&material, |r, _| [0.0, g * r], |_, _| 0.0);
    let trace = 3.0 + g * g;
    let b = [1.0, 1.0 + g * g, 1.0, g];
    let expected = [b[0] - trace / 3.0, b[1] - trace / 3.0, b[2] - trace / 3.0, b[3]].map(|b| 300.0 * b);
    is_uniform(&fields, "stress_effective_Pa", &expected);
    is_uniform(&fields, "vertical_stretch", &[1.0]);
}

/// Pressure linear in the undeformed height and radius: Darcy's law (Eq. 11) in the deformed sample.
#[test]
fn seepage_of_a_linear_pressure() {
    let (radial, axial) = (1.1, 0.75);
    let (along_r, along_z) = (3e5, -8e5);
    let material = MaterialParameters { n0s: 0.2, ..MaterialParameters::default() };
    let fields = block(
        &material,
        |r, z| [(radial - 1.0) * r, (axial - 1.0) * z],
        |r, z| 10.0 + along_r * r + along_z * z,
    );
    let j = radial * radial * axial;
    let mobility = material.permeability / material.fluid_viscosity * (j - 0.2) / (1.0 - 0.2);
    let gradient = [along_r / radial, along_z / axial];
    let w = gradient.map(|g| -mobility * g);
    is_uniform(&fields, "seepage_velocity_m_per_s", &[w[0], 0.0, w[1]]);
    // Per undeformed volume: J w^2 / mobility.
    let porous = j * mobility * (gradient[0] * gradient[0] + gradient[1] * gradient[1]);
    is_uniform(&fields, "porous_dissipation_W_per_m3", &[porous]);
    for (index, &[r, _, z]) in fields.points.iter().enumerate() {
        let p = fields.at_points("pore_pressure_Pa").unwrap().row(index)[0];
        assert_relative_eq!(p, 10.0 + along_r * r + along_z * z, max_relative = 1e-12);
    }
}

fn coarse() -> Parameters {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = MeshPreset::Coarse;
    parameters
}

/// Fields on the way change no bit of the results, and at a time between two steps they are those of the run.
#[test]
fn asking_for_fields_changes_nothing() {
    let model = Model::new(coarse()).unwrap();
    let run = |ask: bool| {
        let mut instance = Instance::new(&model, -1e-5).unwrap();
        let mut forces = Vec::new();
        for k in 1..=12 {
            instance.set_displacement(1e-5 * f64::from(k.min(8)) - 1e-5);
            instance.advance(7e-3).unwrap();
            forces.push(instance.outputs());
            if ask {
                let fields = instance.fields().unwrap();
                let outputs = instance.outputs();
                let punch = fields.at_points("contact").unwrap();
                for index in (0..fields.points.len()).filter(|&i| punch.row(i)[0] == 1.0) {
                    let u = fields.at_points("displacement_m").unwrap().row(index)[2];
                    assert_relative_eq!(u, -outputs.indentation, max_relative = 1e-9, epsilon = 1e-15);
                }
                assert_eq!(punch.values.contains(&1.0), k > 1, "{k}");
                let integral = |name| -> f64 {
                    let volumes = &fields.in_cells("undeformed_volume_m3").unwrap().values;
                    fields.in_cells(name).unwrap().values.iter().zip(volumes).map(|(v, w)| v * w).sum()
                };
                if k > 2 {
                    let viscous = integral("viscous_dissipation_W_per_m3");
                    assert_relative_eq!(viscous, outputs.viscous_dissipation_rate, max_relative = 2e-2);
                    let porous = integral("porous_dissipation_W_per_m3");
                    assert_relative_eq!(porous, outputs.porous_dissipation_rate, max_relative = 2e-2);
                }
            }
        }
        (forces, instance.statistics())
    };
    assert!(run(false) == run(true));
}

/// The laws of the fields are those of the run also with the effects of the specimen.
#[test]
fn effects_of_the_specimen_are_in_the_fields() {
    let mut parameters = coarse();
    parameters.effect.softening.loss = 0.3;
    parameters.effect.eyring.inverse_stress = 5e-3;
    parameters.effect.modulus_drift.rate = 0.05;
    parameters.effect.permeability.exponent = 4.0;
    let mut instance = Instance::new(&Model::new(parameters).unwrap(), 0.0).unwrap();
    assert!(instance.fields().is_ok(), "before anything happened");
    for k in 1..=10 {
        instance.set_displacement(5e-5 * f64::from(k));
        instance.advance(0.03).unwrap();
    }
    let (fields, outputs) = (instance.fields().unwrap(), instance.outputs());
    let volumes = &fields.in_cells("undeformed_volume_m3").unwrap().values;
    for (name, expected) in [
        ("viscous_dissipation_W_per_m3", outputs.viscous_dissipation_rate),
        ("porous_dissipation_W_per_m3", outputs.porous_dissipation_rate),
    ] {
        let values = &fields.in_cells(name).unwrap().values;
        let integral: f64 = values.iter().zip(volumes).map(|(v, w)| v * w).sum();
        assert_relative_eq!(integral, expected, max_relative = 5e-3);
    }
}

#[test]
fn the_three_dimensional_model_says_what_to_do() {
    let mut parameters = coarse();
    parameters.mesh.kind = MeshKind::Paper3d;
    let mut instance = Instance::new(&Model::new(parameters).unwrap(), 0.0).unwrap();
    let error = instance.fields().unwrap_err().to_string();
    assert!(error.contains("paper-3d") && error.contains("axisymmetric"), "{error}");
}
