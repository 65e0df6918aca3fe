//! Cases whose cause the diagnosis does not know.

use super::program::{directory, fail, json, one_line, repository, succeed, text};

/// Cases of the wide ground, by the independent solver, with an effect whose visibility is computed from derivatives at what was drawn.
#[test]
#[ignore = "long: cases by the independent solver"]
fn cases_are_made_and_their_key_is_sealed() {
    let d = directory();
    let (cases, key) = (d.path().join("cases"), d.path().join("key.json"));
    let (out, sealed) = (text(&cases), text(&key));
    let asked = ["--seed", "7", "--cases", "2", "--kinds", "single,null"];
    succeed(&[&["challenge", "make"][..], &asked, &["--out", out, "--key", sealed]].concat());
    let folders: Vec<_> =
        std::fs::read_dir(cases.join("cases")).unwrap().map(|e| e.unwrap().path()).collect();
    let full = folders.iter().filter(|f| f.join("P1.csv").is_file() && f.join("P2.csv").is_file()).count();
    assert_eq!(full, 2, "{folders:?}");
    assert!(key.is_file());
}

/// The wide ground is not computed with the model: its mesh is no matter there.
#[test]
fn the_model_s_mesh_is_refused_for_the_wide_ground() {
    let d = directory();
    let out = d.path().join("cases");
    let told = one_line(&fail(&["challenge", "make", "--mesh", "fine", "--out", text(&out)]));
    assert!(told.contains("--mesh") && told.contains("--ground near"), "{told}");
}

/// Nothing of a challenge is lost to another one: neither its cases, nor its key, nor what opens it.
#[test]
fn a_challenge_is_not_made_over_another_one() {
    let d = directory();
    let place = |name: &str| d.path().join(name);
    let make = |out: &str, key: &str, secret: &str| {
        let [out, key, secret] = [out, key, secret].map(|name| text(&place(name)).to_owned());
        let asked = "challenge make --cases 1 --kinds null --ground near --mesh coarse".split(' ');
        let places = ["--out", &out, "--key", &key, "--secret", &secret];
        asked.chain(places).map(str::to_owned).collect::<Vec<_>>()
    };
    let refused = |all: &[String]| one_line(&fail(&all.iter().map(String::as_str).collect::<Vec<_>>()));
    succeed(&make("one", "one.key", "one.secret").iter().map(String::as_str).collect::<Vec<_>>());
    let before = ["one.key", "one.secret"].map(|file| std::fs::read(place(file)).unwrap());
    for (option, all) in [
        ("--out", make("one", "two.key", "two.secret")),
        ("--key", make("two", "one.key", "two.secret")),
        ("--secret", make("two", "two.key", "one.secret")),
    ] {
        let told = refused(&all);
        assert!(told.contains(option) && told.contains("another run"), "{told}");
    }
    assert_eq!(before, ["one.key", "one.secret"].map(|file| std::fs::read(place(file)).unwrap()));
    assert!(!place("two/cases").exists(), "nothing is left of what was refused");
}

/// Two batches are scored as one, and no key is opened while a case of any of them has no answer.
#[test]
fn several_batches_need_a_secret_each_and_all_their_answers() {
    let d = directory();
    let batch = |name: &str| {
        let (folder, secret) = (d.path().join(name), d.path().join(format!("{name}.secret")));
        let asked = ["--cases", "1", "--kinds", "null", "--ground", "near", "--mesh", "coarse"];
        succeed(
            &[&["challenge", "make"][..], &asked, &["--out", text(&folder), "--secret", text(&secret)]]
                .concat(),
        );
        (text(&folder).to_owned(), text(&secret).to_owned())
    };
    let (one, two) = (batch("one"), batch("two"));
    let score = |secrets: &[&str]| {
        let secrets = secrets.iter().flat_map(|s| ["--secret", s]).collect::<Vec<_>>();
        one_line(&fail(&[&["challenge", "score", &one.0, &two.0][..], &secrets].concat()))
    };
    let told = score(&[&one.1]);
    assert!(told.contains("--secret") && told.contains("1 for 2"), "{told}");
    let told = score(&[&one.1, &two.1]);
    assert!(told.contains("no answer yet") && told.contains("--unfinished"), "{told}");
    // The key is an input: no table replaces it.
    let (answers, key) = (d.path().join("one/answers"), d.path().join("one.key.json"));
    std::fs::create_dir(&answers).unwrap();
    let case = std::fs::read_dir(d.path().join("one/cases")).unwrap().next().unwrap().unwrap().file_name();
    let answer = answers.join(format!("{}.json", text(std::path::Path::new(&case))));
    std::fs::copy(repository("data/withheld/reports/0446ee.json"), answer).unwrap();
    let before = std::fs::read(&key).unwrap();
    let over = ["challenge", "score", &one.0, "--secret", &one.1, "--out", text(&key)];
    let told = one_line(&fail(&over));
    assert!(told.contains("an input of this command"), "{told}");
    assert_eq!(std::fs::read(&key).unwrap(), before);
    // A case may be left out by its name.
    let without = |id: &str| {
        let place = d.path().join("without");
        let asked =
            ["challenge", "score", &one.0, "--secret", &one.1, "--out", text(&place), "--without", id];
        asked.map(str::to_owned)
    };
    let told = one_line(&fail(&without("0").each_ref().map(String::as_str)));
    assert!(told.contains("--without 0"), "{told}");
    let told = one_line(&succeed(&without(text(std::path::Path::new(&case))).each_ref().map(String::as_str)));
    assert!(told.contains("Not counted: "), "{told}");
    // What was scored before is added to, and no case twice.
    let scored = d.path().join("scored.json");
    let again = ["challenge", "score", &one.0, "--secret", &one.1, "--out", text(&scored)];
    succeed(&again);
    let twice = one_line(&fail(&[&again[..], &["--with", text(&scored)]].concat()));
    assert!(twice.contains("in both tables"), "{twice}");
    let blind = repository("data/challenges/blind.json");
    let both = d.path().join("both");
    let both_asked = ["challenge", "score", &one.0, "--secret", &one.1, "--with", text(&blind)];
    succeed(&[&both_asked[..], &["--out", text(&both)]].concat());
    let nulls = |file| json(file)["diagnosis"]["false_accusations"]["of"].as_u64().unwrap();
    assert_eq!(nulls(&both.with_extension("json")), nulls(&blind) + 1);
}
