//! Other people's data, from the folder that SHUTTERLAB_GOLDEN names: the trials that pwcmp comes with.

use serde_json::Value;
use shutterlab_analysis::input::pwcmp;
use std::path::PathBuf;

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn the_trials_of_pwcmp_are_read() {
    let folder = PathBuf::from(std::env::var_os("SHUTTERLAB_GOLDEN").unwrap());
    let scenes = pwcmp::read(&folder.join("pwcmp_ex3_video_tmo_raw.csv")).unwrap();
    assert_eq!(scenes.iter().map(|scene| scene.choices.len()).sum::<usize>(), 1213);
    let text = std::fs::read_to_string(folder.join("incomplete_video_tmo_bt.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let expected = expected["scenes"].as_object().unwrap();
    assert!(expected.len() > 1 && scenes.iter().any(|scene| expected.contains_key(&scene.name)));
    for scene in scenes.iter().filter(|scene| expected.contains_key(&scene.name)) {
        let table = &expected[&scene.name];
        let labels: Vec<&str> = table["labels"]
            .as_array()
            .unwrap()
            .iter()
            .map(|label| label.as_str().unwrap())
            .collect();
        let mut wins = vec![vec![0; labels.len()]; labels.len()];
        for choice in &scene.choices {
            let place = |name: &str| labels.iter().position(|label| *label == name).unwrap();
            let (a, b) = (place(&choice.a), place(&choice.b));
            let (winner, loser) = if choice.a_selected { (a, b) } else { (b, a) };
            wins[winner][loser] += 1;
        }
        assert_eq!(serde_json::json!(wins), table["wins"], "{}", scene.name);
    }
}
