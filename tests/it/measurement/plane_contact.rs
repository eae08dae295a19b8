//! Heights over a plane: the model that they give predicts other heights as well as its covariance says.

use std::sync::Arc;

use crate::common::campaign::{Campaign, campaign, campaign_of, held_out_over_predicted};
use crate::common::{machine, text};
use paracal::files::{Machine, read_measurement};
use paracal::identification::{
    CalibrationOptions, CalibrationProblem, Identifier, LevenbergMarquardt, PriorPolicy, Task, calibrate, evaluate,
};
use paracal::measurement::{
    Contact, ContactReading, DataRow, Dataset, Frames, MeasurementModel, Noise, Plane, PlaneContact, Sample,
};
use paracal::mechanism::{Body, rigid_directions};
use paracal::nalgebra::{DMatrix, DVector, Rotation3, Vector3};
use paracal::pose::Pose;
use paracal::simulation::draw_parameters;
use paracal::solve::LeastSquaresProblem;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SIGMA: f64 = 1e-6;
const TIP: [f64; 3] = [0.25, -0.4, -0.15];
const NORMAL: [f64; 3] = [0.06, -0.08, 0.995];
const DISTANCE: f64 = 0.21;

/// Heights of the tip of the true platform over the plane `NORMAL · p = DISTANCE`, from the definition of a height.
fn heights(c: &Campaign) -> Vec<ContactReading> {
    let mut rng = ChaCha8Rng::seed_from_u64(81);
    let length = NORMAL.iter().map(|v| v * v).sum::<f64>().sqrt();
    let height = |pose: &Pose| {
        let r = pose.rotation.matrix();
        let tip = [0, 1, 2].map(|i| pose.position[i] + (0..3).map(|j| r[(i, j)] * TIP[j]).sum::<f64>());
        (0..3).map(|i| NORMAL[i] * tip[i]).sum::<f64>() / length - DISTANCE
    };
    let reading = |pose: &Pose| {
        let z: f64 = StandardNormal.sample(&mut rng);
        ContactReading { height: Some(height(pose) + SIGMA * z), sigma: SIGMA }
    };
    c.run.iter().map(|s| s.truth).collect::<Vec<_>>().iter().map(reading).collect()
}

fn stated(known: bool) -> Contact {
    let tip = Vector3::from(TIP);
    let plane = match known {
        true => Plane::new(&Vector3::from(NORMAL), DISTANCE).unwrap(),
        // A plane on a drawing, five degrees and five centimetres off.
        false => Plane::new(&Vector3::z(), DISTANCE - 0.05).unwrap(),
    };
    Contact { plane, tip, known }
}

fn contact_data(c: &Campaign, known: bool) -> (Dataset, Arc<PlaneContact>) {
    let model = Arc::new(PlaneContact::new(stated(known), heights(c)));
    (Dataset::new(c.samples.clone(), model.clone(), Noise::stated(SIGMA, SIGMA)), model)
}

#[test]
fn held_out_heights_err_as_the_covariance_says() {
    let c = campaign(800);
    for known in [true, false] {
        let ratio = held_out_over_predicted(&c, &contact_data(&c, known).0, 200);
        assert!((0.85..1.15).contains(&ratio), "known {known}: {ratio:.3}");
    }
}

#[test]
fn estimates_err_as_their_covariance_says() {
    const DRAWS: u64 = 12;
    for known in [true, false] {
        let (mut sum, mut free) = (0.0, 0);
        for draw in 0..DRAWS {
            let nominal = machine("table5").mechanism;
            // The truth is drawn from the tolerances, as the prior has it.
            let values = draw_parameters(nominal.as_ref(), None, &mut ChaCha8Rng::seed_from_u64(draw));
            let truth = nominal.with_values(&values, nominal.home()).unwrap();
            let c = campaign_of(nominal, truth, 150);
            let (data, model) = contact_data(&c, known);
            let task = Task { prior: PriorPolicy::Tolerance, ..Task::new(c.nominal.as_ref(), &data) };
            let found = LevenbergMarquardt::default().identify(&task).unwrap();
            let mut error: Vec<f64> = found.mechanism_values().iter().zip(&values).map(|(v, t)| v - t).collect();
            if !known {
                // The identified plane against the true one; its tilts turn the normal about x and y.
                let plane = model.located(&found.own_values()).plane;
                let wanted = stated(true).plane;
                let turned = plane.normal.cross(&wanted.normal);
                error.extend([-turned.x, -turned.y, plane.distance - wanted.distance]);
            }
            let n = error.len();
            let error = DVector::from_vec(error);
            sum += error.dot(&found.covariance.clone().cholesky().unwrap().solve(&error));
            free += n;
        }
        // 504 and 540 squares of normal numbers: 1 ± 0.06.
        let ratio = sum / free as f64;
        assert!((0.8..1.2).contains(&ratio), "known {known}: {ratio:.3}");
    }
}

#[test]
fn a_calibration_with_heights_is_trusted_and_finds_the_plane() {
    let c = campaign(300);
    for known in [true, false] {
        let (data, model) = contact_data(&c, known);
        let options = CalibrationOptions::default();
        let identifier = LevenbergMarquardt::default();
        let result = calibrate(c.nominal.as_ref(), &data, Some(&c.space), &identifier, &options).unwrap();
        assert!(result.verdict.trusted, "{:?}", result.verdict);
        assert!(!result.registration.applied && result.identification.prior);
        assert!(result.after.rotation.is_none() && result.after.position.unwrap() < 1.2 * SIGMA, "{:?}", result.after);
        let held = result.held_out.unwrap().rms.position.unwrap();
        assert!(held < 1.5 * SIGMA, "known {known}: {held:.2e}");
        assert!(result.before.position.unwrap() > 50.0 * SIGMA, "{:?}", result.before);
        let located = model.located(&result.identification.own_values());
        assert!(located.known && located.tip == Vector3::from(TIP));
        // The plane is known as far as the tolerances hold the base.
        let turned = located.plane.normal.cross(&stated(true).plane.normal).norm();
        assert!(turned < 2e-3 && (located.plane.distance - DISTANCE).abs() < 2e-3, "{located:?}");
    }
}

/// Motions of all points that no row sees, or that an unknown plane takes in.
#[test]
fn what_heights_do_not_see_is_what_the_documentation_says() {
    let c = campaign(120);
    let m = c.nominal.as_ref();
    let ones = vec![1.0; m.parameters().len()];
    let normal = Vector3::from(NORMAL).normalize();
    // Motions (shift, turn about the origin) of a body in parameters.
    let moved = |body: Body, shift: Vector3<f64>, turn: Vector3<f64>, through: Vector3<f64>| -> DVector<f64> {
        let basis = rigid_directions(m, body, &ones);
        let points = body.points(m, m.values());
        let centre = points.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / points.len() as f64;
        let shift = shift + turn.cross(&(centre - through));
        (0..3).map(|k| &basis[k] * shift[k] + &basis[k + 3] * turn[k]).sum()
    };
    let axis = |k: usize| Vector3::ith(k, 1.0);
    let (zero, tip) = (Vector3::zeros(), Vector3::from(TIP));
    let along = [normal.cross(&axis(0)), normal.cross(&axis(1))];
    let mut unseen: Vec<DVector<f64>> = (0..3).map(|k| moved(Body::Platform, zero, axis(k), tip)).collect();
    unseen.extend(along.map(|a| moved(Body::Base, a, zero, zero)));
    unseen.push(moved(Body::Base, zero, normal, zero));
    let mut taken_in = vec![moved(Body::Base, normal, zero, zero)];
    taken_in.extend(along.map(|a| moved(Body::Base, zero, a, zero)));
    for known in [true, false] {
        // At the true plane the directions are exact.
        let contact = Contact { known, ..stated(true) };
        let model = Arc::new(PlaneContact::new(contact, heights(&c)));
        let data = Dataset::new(c.samples.clone(), model, Noise::stated(SIGMA, SIGMA));
        let mut problem = CalibrationProblem::new(&Task::new(m, &data)).unwrap();
        let (rows, n) = problem.shape();
        let (mut r, mut j) = (DVector::zeros(rows), DMatrix::zeros(rows, n));
        let mut x = problem.start();
        if !known {
            x.rows_mut(42, 3).copy_from_slice(&[0.0, 0.0, DISTANCE]);
        }
        problem.linearize(&x, &mut r, &mut j).unwrap();
        let mechanism = j.columns(0, 42).into_owned();
        let own = j.columns(42, n - 42).into_owned();
        let left = |direction: &DVector<f64>| {
            let seen = &mechanism * direction;
            let rest = if own.ncols() == 0 {
                seen
            } else {
                let q = own.clone().qr().q();
                &seen - &q * (q.transpose() * &seen)
            };
            rest.norm() / (mechanism.norm() * direction.norm())
        };
        assert!(unseen.iter().all(|d| left(d) < 1e-12), "{:?}", unseen.iter().map(left).collect::<Vec<_>>());
        for d in &taken_in {
            assert!(if known { left(d) > 1e-3 } else { left(d) < 1e-12 }, "known {known}: {:.2e}", left(d));
        }
        let singular = mechanism.clone().svd(false, false).singular_values;
        let rank = singular.iter().filter(|s| **s > 1e-9 * singular.max()).count();
        assert_eq!(rank, 36, "{singular}");
    }
}

#[test]
fn touches_find_a_plane_of_which_little_is_known() {
    // The true platform is led to where its tip touches; every reading is zero.
    let c = campaign(1);
    let plane = Plane::new(&Vector3::new(0.3, 0.2, 0.9), 0.35).unwrap();
    let truth = c.truth.as_ref();
    let mut rng = ChaCha8Rng::seed_from_u64(82);
    let (mut samples, mut readings) = (Vec::new(), Vec::new());
    let at = paracal::conditions::Conditions::unknown();
    for row in 0..200 {
        let mut pose = c.space.random(&mut rng);
        let z: f64 = StandardNormal.sample(&mut rng);
        let tip = pose.place(&Vector3::from(TIP));
        pose.position -= *plane.normal * (plane.normal.dot(&tip) - plane.distance + SIGMA * z);
        let joints = truth.inverse(truth.values(), &pose, &at).unwrap();
        samples.push(paracal::measurement::Sample { row: DataRow(row), joints, ..Default::default() });
        readings.push(ContactReading { height: Some(0.0), sigma: SIGMA });
    }
    let contact = Contact { tip: Vector3::from(TIP), known: false, ..Contact::default() };
    let model = Arc::new(PlaneContact::new(contact, readings));
    let data = Dataset::new(samples, model.clone(), Noise::stated(SIGMA, SIGMA));
    let options = CalibrationOptions::default();
    let result = calibrate(c.nominal.as_ref(), &data, None, &LevenbergMarquardt::default(), &options).unwrap();
    assert!(result.verdict.trusted, "{:?}", result.verdict);
    let found = model.located(&result.identification.own_values()).plane;
    assert!(found.normal.cross(&plane.normal).norm() < 2e-3 && (found.distance - plane.distance).abs() < 2e-3);
    let again = evaluate(result.mechanism.as_ref(), &result.identification.own_values(), &data).unwrap().rms();
    assert!(again.position.unwrap() < 1.2 * SIGMA);
}

#[test]
fn frames_of_the_tracker_carry_the_tip() {
    let base = Pose { position: Vector3::new(1.0, -2.0, 0.5), rotation: Rotation3::from_euler_angles(0.4, -0.2, 2.0) };
    let frames = Frames { base, ..Frames::default() };
    let plane = Plane::new(&Vector3::from(NORMAL), DISTANCE).unwrap();
    let pose = Pose::from_coordinates(&[0.1, 0.2, 0.3, 0.1, -0.2, 0.3]);
    let tip = Vector3::from(TIP);
    let height = plane.height(&pose.place(&tip));
    // The same height over the same plane, both seen from the tracker.
    let contact = Contact { plane: plane.seen_from(&base), tip, known: true };
    let model = PlaneContact::new(contact, vec![ContactReading { height: Some(height), sigma: SIGMA }]);
    let mut rows = paracal::measurement::Rows::sized(1, 0);
    model.evaluate(0, &Sample::default(), &pose, &frames, &[], &mut rows);
    assert!(rows.residual[0].abs() < 1e-15, "{}", rows.residual[0]);
}

const SECTION: &str = "[plane]\nnormal = [0.12, -0.16, 1.99]\ndistance = 210.0\ntip = [250.0, -400.0, -150.0]\n";

#[test]
fn a_plane_is_read_and_written_back() {
    let path = std::path::Path::new("m.toml");
    let plain = text("mechanisms/table5.toml");
    assert_eq!(Machine::from_text(&plain, path).unwrap().contact, Contact::default());
    let m = Machine::from_text(&format!("{plain}\n{SECTION}identify = true\n"), path).unwrap();
    let contact = m.contact;
    assert!(!contact.known && (contact.tip - Vector3::from(TIP)).norm() < 1e-15);
    assert!((*contact.plane.normal - Vector3::from(NORMAL).normalize()).norm() < 1e-15);
    assert!((contact.plane.distance - DISTANCE).abs() < 1e-15);
    let of = |frames: &Frames| {
        let text = m.document_of(m.mechanism.as_ref(), None, frames).unwrap().to_text();
        Machine::from_text(&text, path).unwrap().contact
    };
    assert_eq!(of(&Frames::default()), contact);
    // Carried into other frames, the tip of the same platform pose has the same height.
    let frames = Frames {
        base: Pose::from_coordinates(&[1.0, -2.0, 0.5, 0.4, -0.2, 2.0]),
        target: Pose::from_coordinates(&[0.1, 0.0, 0.3, 0.1, 0.3, -1.0]),
    };
    let pose = Pose::from_coordinates(&[0.1, 0.2, 0.3, 0.1, -0.2, 0.3]);
    let there = of(&frames);
    let height = |c: &Contact, pose: &Pose| c.plane.height(&pose.place(&c.tip));
    assert!((height(&there, &frames.measured(&pose)) - height(&contact, &pose)).abs() < 1e-12);
}

#[test]
fn heights_are_read_with_their_sigmas() {
    let m = machine("table5");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("d.csv");
    let legs = "800,800,800,800,800,800";
    let header = "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,contact_um,sigma_contact_mm";
    std::fs::write(&file, format!("{header}\n{legs},475696,0.002\n{legs},,\n{legs},0,\n")).unwrap();
    let read = read_measurement(&file, &m).unwrap();
    let model = read.data.model();
    assert_eq!((model.describe().as_str(), read.data.row_count()), ("heights over a plane", 2));
    assert!((model.covariance(0, &Frames::default())[(0, 0)].sqrt() - 2e-6).abs() < 1e-15);
    assert!((model.covariance(2, &Frames::default())[(0, 0)].sqrt() - 1e-6).abs() < 1e-15);
    assert_eq!(model.covariance(1, &Frames::default()).shape(), (0, 0));
    // Home is at a height of 475.696 mm.
    let errors = evaluate(m.mechanism.as_ref(), &[], &read.data).unwrap();
    assert!(errors.samples[0].position.unwrap() < 2e-6 && errors.samples[1].position.is_none());
}
