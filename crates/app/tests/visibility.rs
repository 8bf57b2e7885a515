//! What the command line says of whether a difference is seen.

use defocus_study::metrics::Visibility;

/// Runs the program.
fn run(args: &[&str]) -> std::process::Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_defocus")).args(args).output().expect("the program runs")
}

#[test]
fn compare_tells_jod_and_ppd_of_each_method_and_the_cheapest() {
    let folder = tempfile::tempdir().unwrap();
    let json_of = |more: &[&str]| {
        let file = folder.path().join("results.json");
        let mut args = vec!["compare", "cans", "--lens", "hmd", "-E", "6", "--focus", "1", "--size", "96x72"];
        args.extend(["--methods", "pinhole,mipmap,adaptive", "--samples", "16", "--runs", "1", "--no-cache", "-q"]);
        args.extend(["--json", file.to_str().unwrap()]);
        args.extend(more);
        let output = run(&args);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(&file).unwrap();
        (serde_json::from_str::<serde_json::Value>(&text).unwrap(), String::from_utf8(output.stdout).unwrap())
    };
    let (json, text) = json_of(&["--good-enough", "9"]);
    for result in json["results"].as_array().unwrap() {
        assert!((result["ppd"].as_f64().unwrap() - 25.0).abs() < 1e-4, "{result}");
        let quality = result["jod"].as_f64().unwrap();
        let word = serde_json::to_value(Visibility::of_jod(quality)).unwrap();
        assert_eq!(result["visibility"], word);
    }
    assert_eq!(json["viewing"]["screen"]["peak_cd_m2"], 100.0);
    let good = json["results"].as_array().unwrap().iter().filter(|r| r["jod"].as_f64().unwrap() >= 9.0);
    let cheapest = good.min_by(|a, b| {
        let ms = |r: &serde_json::Value| r["gpu_ms"]["median"].as_f64().unwrap_or(f64::INFINITY);
        ms(a).total_cmp(&ms(b))
    });
    assert_eq!(json["good_enough"]["method"], cheapest.map_or(serde_json::Value::Null, |r| r["method"].clone()));
    assert!(text.contains("25.00 px per degree") && text.contains("JOD"), "{text}");
    // The eye sees the same picture finer: FLIP and JOD are others, PSNR is not.
    let (finer, _) = json_of(&["--ppd", "120", "--peak-luminance", "50"]);
    let of = |json: &serde_json::Value, key: &str| json["results"][1][key].as_f64().unwrap();
    assert_eq!(of(&finer, "ppd"), 120.0);
    assert!(of(&finer, "jod") > of(&json, "jod") && of(&finer, "flip") < of(&json, "flip"));
    assert!((of(&finer, "psnr_db") - of(&json, "psnr_db")).abs() < 1e-9);
    assert!((finer["viewing"]["screen"]["black_cd_m2"].as_f64().unwrap() - 0.05).abs() < 1e-12, "the contrast stays");
}

#[test]
fn advice_is_given_for_each_pupil_and_focus() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut args = vec!["advise", "cans", "--lens", "hmd", "--size", "96x72", "--methods", "pinhole,mipmap,separable"];
    args.extend(["--pupils", "2,8", "--focus-distances", "0.6,1,3", "--samples", "16", "--runs", "1", "-q"]);
    args.extend(["-o", out.to_str().unwrap()]);
    let output = run(&args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("advice.json")).unwrap()).unwrap();
    let cells = json["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 6);
    for cell in cells {
        let methods = cell["methods"].as_array().unwrap();
        assert_eq!(methods.len(), 3);
        for method in methods {
            assert_eq!(method["good_enough"], method["jod"].as_f64().unwrap() >= 9.0);
        }
        let good = methods.iter().any(|m| m["good_enough"] == true);
        assert_eq!(cell["cheapest"].is_string(), good);
    }
    let blur = |i: usize| cells[i]["mean_coc_px"].as_f64().unwrap();
    assert!((blur(1) / blur(0) - 4.0).abs() < 1e-6, "a pupil four times as wide");
    assert!(std::fs::read_to_string(out.join("advice.html")).unwrap().contains("focused at 0.60 m"));
}

#[test]
fn the_eye_is_set_from_the_command_line() {
    let json_of = |more: &[&str]| {
        let mut args = vec!["render", "cans", "--method", "mipmap", "--size", "64x48", "--lens", "hmd", "--json", "-"];
        args.extend(more);
        let output = run(&args);
        assert!(output.status.success(), "{more:?}: {}", String::from_utf8_lossy(&output.stderr));
        let notes = String::from_utf8_lossy(&output.stderr).into_owned();
        (serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap(), notes)
    };
    let e = |json: &serde_json::Value| json["lens"]["E"].as_f64().unwrap();
    let (json, _) = json_of(&["--pupil-luminance", "100", "--focus", "1"]);
    assert!((e(&json) - 2.887).abs() < 0.001, "{}", e(&json));
    let (old, _) = json_of(&["--pupil-luminance", "100", "--age", "70", "--focus", "0.5"]);
    assert!(e(&old) < e(&json));
    assert_eq!(old["lens"]["eye"]["accommodation_d"], 0.0);
    assert!(old["lens"]["sharpest_m"].is_null(), "at seventy it stays at infinity");
    let notes = old["notes"].as_array().unwrap();
    assert!(notes.iter().any(|n| n.as_str().unwrap().contains("needs 2 D of accommodation")), "{notes:?}");
    let (myope, _) = json_of(&["--eye", "myope", "--focus", "1"]);
    assert!((myope["lens"]["sharpest_m"].as_f64().unwrap() - 1.0 / 3.0).abs() < 1e-9);
    let (chromatic, _) = json_of(&["--chromatic", "--focus", "1"]);
    assert_eq!(chromatic["lens"]["eye"]["chromatic"], serde_json::json!([617.0, 520.0, 449.0]));
    let (own, _) =
        json_of(&["--chromatic=630,530,460", "--sphere", "-1.5", "--cylinder", "-1", "--axis", "90", "--focus", "1"]);
    assert_eq!(own["lens"]["eye"]["chromatic"][0], 630.0);
    assert_eq!(own["lens"]["eye"]["refraction"]["axis_deg"], 90.0);
    for (wrong, says) in [
        (["--accommodation", "99"], "accommodation"),
        (["--eye", "cyclops"], "the eyes are"),
        (["--sphere", "99"], "sphere"),
        (["--pupil-luminance", "-4"], "cd/m2"),
        (["--peak-luminance", "0"], "peak luminance"),
        (["--ppd", "0"], "pixels per degree"),
    ] {
        let mut args = vec!["render", "cans", "--size", "64x48", "--json", "-"];
        args.extend(wrong);
        let output = run(&args);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(says), "{wrong:?}: {text}");
    }
}

#[test]
fn point_spread_functions_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let exr = folder.path().join("psf.exr");
    let mut args = vec!["psf", "--methods", "mipmap,separable", "--coc", "2,4", "--side", "front", "-q"];
    args.extend(["-o", out.to_str().unwrap(), "--export", exr.to_str().unwrap()]);
    let output = run(&args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in ["psf.html", "psf.csv", "psf.png"] {
        assert!(out.join(file).metadata().unwrap().len() > 100, "{file}");
    }
    assert!(exr.metadata().unwrap().len() > 100);
    let wrong = run(&["psf", "--coc", "0"]);
    assert!(!wrong.status.success() && String::from_utf8_lossy(&wrong.stderr).contains("CoC diameters"));
}
