//! What the command line says of whether a difference is seen.

use defocus_study::metrics::Visibility;

/// Runs the program.
fn cli(args: &[&str]) -> std::process::Output {
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
        let output = cli(&args);
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
