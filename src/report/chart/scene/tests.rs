//! Tests of the projection, the order, the labels and robustness.

use super::camera::{Camera, between, distance};
use super::layout::{self, MIST, mix};
use super::shapes::Drawing;
use super::stage::{Ground, Stage};
use super::{Arrow, Dot, LineSegment, Scene, Silhouette, Triad, View};
use crate::report::chart::svg::{DARK, GROUND, INK, LIGHT};
use crate::report::chart::tests::{Dice, check_picture, contrast};

const SIZE: [f64; 2] = [720.0, 440.0];
const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn ring(radius: f64, z: f64, corners: usize) -> Vec<[f64; 3]> {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / corners as f64;
    (0..corners).map(|i| [radius * angle(i).cos(), radius * angle(i).sin(), z]).collect()
}

fn outline(name: &str, points: Vec<[f64; 3]>, filled: bool, thin: bool) -> Silhouette {
    Silhouette { name: name.into(), colour: 2, points, filled, thin }
}

fn leg(label: &str, from: [f64; 3], to: [f64; 3]) -> LineSegment {
    LineSegment { name: "leg".into(), colour: 0, from, to, label: label.into() }
}

/// A hexapod with some poses, each with an arrow at every corner.
fn hexapod(poses: usize) -> Scene {
    let (base, top) = (ring(1.2, 0.0, 6), ring(1.0, 0.8, 6));
    let mut scene = Scene {
        title: "hexapod".into(),
        unit: ("m", 1.0),
        outlines: vec![
            outline("base", ring(1.2, 0.0, 48), false, false),
            outline("platform", top.clone(), true, false),
        ],
        legs: (0..6).map(|i| leg(&(i + 1).to_string(), base[i], top[(i + i % 2) % 6])).collect(),
        frames: vec![Triad { label: "base".into(), origin: [0.0; 3], axes: AXES, length: 0.4 }],
        note: "Arrows are 2000 times as long as the errors.".into(),
        ..Scene::default()
    };
    let mut dice = Dice(5);
    for pose in 0..poses {
        let mut near = |p: &[f64; 3]| p.map(|v| v + 0.1 * (dice.roll(1000) as f64 / 500.0 - 1.0));
        let corners: Vec<[f64; 3]> = top.iter().map(&mut near).collect();
        for from in &corners {
            let (name, tip) = ("error".into(), format!("pose {pose}: 23.4 µm"));
            scene.arrows.push(Arrow { name, colour: 1, from: *from, to: near(from), tip, label: String::new() });
        }
        scene.outlines.push(Silhouette { colour: 5, ..outline("chosen poses", corners, false, true) });
    }
    scene
}

fn check(scene: &Scene) -> String {
    let text = scene.svg_with_id("s");
    assert_eq!(text, scene.svg_with_id("s"));
    let canvas = layout::compose(scene, "s", layout::WHOLE);
    check_picture(&canvas, &text, scene);
    let narrow = layout::compose(scene, "s", layout::NARROW);
    check_picture(&narrow, &narrow.finish("", ""), scene);
    for [x, y] in places(&text) {
        assert!((0.0..=canvas.width).contains(&x) && (0.0..=canvas.height).contains(&y), "{x} {y}: {scene:?}");
    }
    text
}

/// The absolute places in the paths of a picture.
fn places(text: &str) -> Vec<[f64; 2]> {
    let number = |t: Option<&str>| t.and_then(|t| t.parse().ok()).expect("number");
    let mut all = Vec::new();
    for d in text.split(" d=\"").skip(1).filter_map(|t| t.split('"').next()) {
        for part in d.split(['M', 'L']).skip(1) {
            let mut numbers = part.split(|c: char| c == ' ' || c.is_ascii_alphabetic());
            all.push([number(numbers.next()), number(numbers.next())]);
        }
    }
    all
}

#[test]
fn projection_agrees_with_hand_computed_points() {
    // From (2, 0, 0) a point one half of that way off appears twice as large; y points to the right.
    let camera = Camera::new(&View { azimuth: 0.0, elevation: 0.0, distance: 2.0 });
    let (px, depth) = camera.project([1.0, 0.5, 0.25]);
    assert_eq!((px, depth), ([1.0, -0.5], 1.0));
    // From 30° above negative y, worked out with cos 30° = 0.866025: the axis of the camera is (0, −0.866025, 0.5).
    let view = View { azimuth: -std::f64::consts::FRAC_PI_2, elevation: std::f64::consts::FRAC_PI_6, distance: 3.0 };
    let (px, depth) = Camera::new(&view).project([0.3, 0.4, 0.5]);
    assert!((depth - 3.096_410).abs() < 1e-6, "{depth}");
    assert!((px[0] - 0.290_659).abs() < 1e-6 && (px[1] + 0.613_303).abs() < 1e-6, "{px:?}");
}

#[test]
fn straight_lines_stay_straight_and_parallels_meet() {
    let stage = Stage::new(&hexapod(3), [0.0; 2], SIZE, 18.0);
    let mut dice = Dice(3);
    for _ in 0..200 {
        let [a, b] = [0, 1].map(|_| [0; 3].map(|_| dice.value(3) - 3.5));
        let s = dice.value(3) - 3.0;
        let [p, q, r] = [a, between(a, b, s), b].map(|v| stage.see(&v).expect("finite").px);
        let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        assert!(area.abs() < 1e-6, "{area}");
        let inside = (q[0] - p[0]) * (q[0] - r[0]) + (q[1] - p[1]) * (q[1] - r[1]);
        assert!(inside <= 1e-9);
    }
    // Seen along y, a line across is as short as it is far away.
    let view = View { azimuth: -std::f64::consts::FRAC_PI_2, ..View::default() };
    let stage = Stage::new(&Scene { view, ..hexapod(0) }, [0.0; 2], SIZE, 18.0);
    let depth = |y: f64| stage.see(&[0.0, y, 0.0]).expect("finite").depth;
    let width = |y: f64| {
        let end = |x: f64| stage.see(&[x, y, 0.0]).expect("finite").px;
        (end(1.0)[0] - end(-1.0)[0]).hypot(end(1.0)[1] - end(-1.0)[1])
    };
    assert!((width(-1.0) / width(1.0) - depth(1.0) / depth(-1.0)).abs() < 1e-9 && depth(1.0) > 1.2 * depth(-1.0));
}

#[test]
fn far_things_are_painted_first() {
    let top = |elevation: f64| Scene {
        view: View { elevation, ..View::default() },
        outlines: vec![outline("top", ring(1.0, 1.0, 24), true, false)],
        legs: vec![leg("", [0.0, 0.0, 0.4], [0.0, 0.0, 0.9])],
        arrows: vec![Arrow { from: [0.0, 0.0, 1.1], to: [0.0, 0.0, 1.5], ..Arrow::default() }],
        ..Scene::default()
    };
    let order = |elevation: f64| {
        let text = check(&top(elevation));
        let drawing = text.find("-grid\" d").expect("grid");
        let after = |what: &str| text[drawing..].find(what).expect("painted");
        (after("long</title>"), after("s-band"), after("s-arrow"))
    };
    let (leg, face, arrow) = order(0.9);
    assert!(leg < face && face < arrow, "{leg} {face} {arrow}");
    let (leg, face, arrow) = order(-0.9);
    assert!(arrow < face && face < leg, "{leg} {face} {arrow}");

    let scene = hexapod(2);
    let stage = Stage::new(&scene, [0.0; 2], SIZE, 18.0);
    let items = Drawing::new(&scene, &stage).items;
    let width = |depth: f64| items.iter().filter(|i| i.class == "edge" && i.halo.is_some() && i.depth < depth).count();
    assert!(width(f64::INFINITY) > 6);
    for (a, b) in items.iter().zip(items.iter().skip(1)).filter(|(a, b)| a.halo.is_some() && b.halo.is_some()) {
        assert!((a.depth < b.depth) == (a.middle.depth < b.middle.depth));
        assert!(a.depth > b.depth || a.width >= b.width, "nearer pieces are not thinner");
    }
}

#[test]
fn pictures_fit_from_everywhere() {
    for azimuth in [-3.0, -1.1, 0.0, 2.0, 1e9, f64::NAN] {
        for elevation in [-9.0, -0.4, 0.0, 0.3, 1.571, f64::INFINITY] {
            for distance in [0.0, 1.5, 4.0, 1e300, f64::NAN] {
                check(&Scene { view: View { azimuth, elevation, distance }, ..hexapod(1) });
            }
        }
    }
}

#[test]
fn a_hundred_poses_are_small() {
    let text = check(&hexapod(100));
    assert!(text.len() < 150_000, "{}", text.len());
    assert!(!text.contains("µm"), "very many arrows have no tooltips");
    let text = check(&hexapod(20));
    assert!(text.len() < 60_000 && text.contains("<title>pose 19: 23.4 µm</title>"), "{}", text.len());
}

#[test]
fn names_are_in_the_legend_once() {
    let canvas = layout::compose(&hexapod(20), "x", layout::WHOLE);
    for name in ["base", "platform", "leg", "error", "chosen poses"] {
        // The label of the frame is another text.
        let wanted = if name == "base" { 2 } else { 1 };
        assert_eq!(canvas.boxes.iter().filter(|b| b.text == name).count(), wanted, "{name}");
    }
    for text in ["1", "2", "3", "4", "5", "6", "x", "y", "z"] {
        assert_eq!(canvas.boxes.iter().filter(|b| b.text == text).count(), 1, "{text}");
    }
}

#[test]
fn labels_without_a_place_remain_in_the_tooltip() {
    let legs = (0..90).map(|i| leg(&format!("number {i}"), [0.0; 3], [0.0, 0.0, 1.0])).collect();
    let scene = Scene { legs, unit: ("mm", 1e-3), ..Scene::default() };
    let text = check(&scene);
    let shown =
        layout::compose(&scene, "s", layout::WHOLE).boxes.iter().filter(|b| b.text.starts_with("number")).count();
    assert!((1..60).contains(&shown), "{shown}");
    assert!(text.contains("<title>leg number 89: 1000 mm long</title>"));
}

#[test]
fn the_ground_tells_the_scale() {
    let ground = |scene: &Scene| -> Ground { Stage::new(scene, [0.0; 2], SIZE, 18.0).ground };
    let own = ground(&hexapod(0));
    assert!((own.step - 0.2).abs() < 1e-12 && own.z == 0.0, "{own:?}");
    assert!(own.low[0] <= -1.2 && own.low[0] + own.count[0] as f64 * own.step >= 1.2);
    // Round numbers of the unit, not of metres.
    let feet = Scene { unit: ("ft", 0.3048), ..hexapod(0) };
    assert!((ground(&feet).step / 0.3048 - 1.0).abs() < 1e-9);
    assert!(check(&feet).contains("Squares on the ground are 1\u{a0}ft wide; the ground is at z = 0\u{a0}ft."));
    for lines in [own.lines(), ground(&Scene::default()).lines()] {
        assert!(lines.len() >= 4 && lines.iter().all(|[a, b]| distance(*a, *b) > 0.0));
    }
}

#[test]
fn any_data_gives_a_picture() {
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    check(&Scene::default());
    let dot = |at| Dot { name: "d".into(), colour: 1, at, tip: String::new() };
    for at in [[0.0; 3], [5.0; 3], [nan; 3], [1e300; 3], [-1e99, 1e99, 0.0], [1e-300; 3], [inf, 0.0, 0.0]] {
        let one = check(&Scene { dots: vec![dot(at)], ..Scene::default() });
        let drawn = one.matches("<title>d</title>").count();
        assert_eq!(drawn, usize::from(at.iter().all(|v| v.abs() < 1e100)), "{at:?}");
        check(&Scene { dots: vec![dot(at); 3], legs: vec![leg("1", at, [1.0; 3])], ..Scene::default() });
    }
    let gap = outline("gap", vec![[0.0; 3], [1.0, 0.0, 0.0], [nan; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], true, false);
    let text = check(&Scene { outlines: vec![gap], ..Scene::default() });
    assert_eq!(text.matches("s-band\"").count(), 1, "the swatch alone");
    for count in 0..4 {
        for thin in [true, false] {
            let few = outline("few", ring(1.0, 0.0, count), true, thin);
            check(&Scene { outlines: vec![few.clone(), few], ..Scene::default() });
        }
    }
    for unit in [("m", nan), ("m", 0.0), ("m", -1.0), ("km", 1e3), ("", 1e300)] {
        check(&Scene { unit, ..hexapod(1) });
    }
}

#[test]
fn nasty_scenes_are_sound() {
    let mut dice = Dice(17);
    for _ in 0..150 {
        let kind = dice.roll(6);
        let mut scene = Scene { title: dice.text(), note: dice.text(), ..Scene::default() };
        scene.view = View { azimuth: dice.value(5), elevation: dice.value(5), distance: dice.value(kind) };
        for _ in 0..dice.roll(5) {
            let points = (0..dice.roll(9)).map(|_| [0; 3].map(|_| dice.value(kind))).collect();
            let (filled, thin) = (dice.roll(2) == 0, dice.roll(2) == 0);
            scene.outlines.push(Silhouette { name: dice.text(), colour: dice.roll(100), points, filled, thin });
        }
        for _ in 0..[0, 1, 6, 90][dice.roll(4)] {
            let [from, to] = [0, 1].map(|_| [0; 3].map(|_| dice.value(kind)));
            scene.legs.push(LineSegment { name: dice.text(), colour: dice.roll(9), from, to, label: dice.text() });
            scene.arrows.push(Arrow {
                name: dice.text(),
                colour: dice.roll(9),
                from: to,
                to: from,
                tip: dice.text(),
                label: dice.text(),
            });
        }
        for _ in 0..dice.roll(4) {
            let axes = [0; 3].map(|_| [0; 3].map(|_| dice.value(kind)));
            let origin = [0; 3].map(|_| dice.value(kind));
            scene.frames.push(Triad { label: dice.text(), origin, axes, length: dice.value(kind) });
            scene.dots.push(Dot { name: dice.text(), colour: dice.roll(9), at: origin, tip: dice.text() });
        }
        check(&scene);
    }
}

#[test]
fn scenes_are_kept_apart_and_names_escaped() {
    let (a, b) = (hexapod(1), Scene { title: "other".into(), ..hexapod(1) });
    let id = |s: &Scene| s.svg().split(" id=\"").nth(1).and_then(|t| t.split('"').next()).map(str::to_owned);
    assert!(id(&a).is_some() && id(&a) != id(&b));
    assert_eq!(a.svg(), a.svg());
    for part in [" id=\"", " class=\""] {
        assert!(a.svg_with_id("one").split(part).skip(1).all(|t| t.starts_with("one")));
    }
    let mut scene = hexapod(1);
    let name = "<i>&\"x\"";
    scene.title = name.into();
    scene.outlines[0].name = name.into();
    scene.legs[0].label = name.into();
    scene.frames[0].label = name.into();
    scene.arrows[0].tip = name.into();
    let text = check(&scene);
    assert!(!text.contains("<i>") && text.matches("&lt;i&gt;&amp;&quot;x&quot;").count() >= 5);
}

#[test]
fn contrasts_suffice_in_the_mist() {
    for (mode, palette) in [LIGHT, DARK].iter().enumerate() {
        for colour in palette {
            // Labels may lie on an area, which tints a fifth of the background.
            assert!(contrast(INK[mode], &mix(GROUND[mode], colour, 0.2)) >= 4.5, "{colour}");
            assert!(contrast(&mix(colour, GROUND[mode], MIST), GROUND[mode]) >= 1.7, "{colour}");
        }
    }
    assert_eq!(mix("#000000", "#ff8040", 0.5), "#804020");
}

#[test]
fn the_drawing_of_a_hexapod_is_as_it_was() {
    insta::assert_snapshot!(hexapod(1).svg_with_id("hexapod"));
}
