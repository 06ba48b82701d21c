use cosmic::Error;
use cosmic::reading::{from_json, placed, read_whole, with_decimal_point};

#[test]
fn errors_in_json_name_the_keys() {
    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Rows {
        #[allow(dead_code)]
        rows: Vec<[f64; 2]>,
    }
    let refusal = |text: &str| {
        let rows = from_json::<Rows>("a.json", 0, text.as_bytes());
        rows.unwrap_err().to_string()
    };
    assert_eq!(
        refusal("{\"rows\": [[1, 2],\n[3, 4, 5]]}"),
        "error: `rows[1]`: too many values\n --> a.json:2:8"
    );
    assert!(refusal("{\"rows\": [[1, 2], [3, null]]}").contains("`rows[1][1]`: invalid type"));
    assert!(refusal("{\"rows\": [[1]]}").contains("`rows[0]`: invalid length 1"));
    assert!(refusal("{}").starts_with("error: missing field `rows`\n"));
    assert!(refusal("{\"rows\": []} x").starts_with("error: trailing characters\n"));
    assert!(refusal("{\"rows\": [], \"row\": 1}").contains("unknown field `row`"));
    for text in ["base = 'earth'", "[physics]", "# a scene", "nothing"] {
        assert!(refusal(text).starts_with("error: this is not JSON\n"));
    }
}

#[test]
fn a_number_that_is_not_finite_is_named_with_its_place() {
    for word in ["NaN", "nan", "-NaN", "Infinity", "-Infinity", "inf", "-inf"] {
        let text = format!("{{\"a\":\n [1, {word}]}}");
        let told = from_json::<serde_json::Value>("a.json", 4, text.as_bytes());
        let says = format!(
            "error: `a[1]`: {word} is not a JSON number; write null for a number that is not \
             finite\n --> a.json:6:6"
        );
        assert_eq!(told.unwrap_err().to_string(), says);
    }
    let text = b"{\"a\": nano}";
    let told = from_json::<serde_json::Value>("a.json", 0, text).unwrap_err();
    assert!(!told.to_string().contains("not finite"), "{told}");
}

#[test]
fn truncated_and_empty_files_are_reported() {
    let refusal = |text: &str| {
        let told = from_json::<serde_json::Value>("a.json", 0, text.as_bytes());
        told.unwrap_err().to_string()
    };
    let whole = r#"{"a": [-1.5e+3, "x"]}"#;
    for end in 1..whole.len() {
        let told = refusal(&whole[..end]);
        assert!(told.contains("the file is truncated or damaged"), "{told}");
    }
    assert_eq!(refusal(" \n"), "error: the file is empty\n --> a.json:2:1");
}

/// A crash of the machine can leave any bytes at the end of a file.
#[test]
fn files_of_any_bytes_are_reported_with_their_place() {
    let zeros = "zero bytes begin here: the file is truncated or damaged";
    let latin = "the byte 0xff is not UTF-8 text; save the file as UTF-8";
    let wide = "the file is UTF-16 or UTF-32 text; save it as UTF-8";
    for (bytes, says, place) in [
        (&b"\0"[..], zeros, "5:1"),
        (&[0; 4096], zeros, "5:1"),
        (b"{\"a\":\n 1\0\0\0\0", zeros, "6:3"),
        (b"{\"a\": \0\0\0\0\0 2}", zeros, "5:7"),
        (b"{\"a\": 2}\n\0", zeros, "6:1"),
        (b"{\"a\":\n \"\xff\xfe\"}", latin, "6:3"),
        (b"\xff\x80\x01", latin, "5:1"),
        (b"{\0\"\0a\0\"\0:\0", wide, "5:1"),
        (b"\0\0\0{\0\0\0}", wide, "5:1"),
        (b"\xff\xfe{\0", wide, "5:1"),
    ] {
        let told = from_json::<serde_json::Value>("a.json", 4, bytes).unwrap_err();
        let expected = format!("error: {says}\n --> a.json:{place}");
        assert_eq!(told.to_string(), expected, "{bytes:?}");
    }
}

#[test]
fn a_typographic_minus_sign_is_named() {
    for (sign, number) in [('\u{2212}', "U+2212"), ('\u{2013}', "U+2013")] {
        let text = format!("{{\"a\": [1,\n {sign}5.0]}}");
        let told = from_json::<serde_json::Value>("a.json", 0, text.as_bytes()).unwrap_err();
        let expected = format!(
            "error: `a[1]`: `{sign}5.0` is not a number: its sign is the character {number}; write -5.0\n --> a.json:2:2"
        );
        assert_eq!(told.to_string(), expected);
    }
}

#[test]
fn frames_of_other_programs_are_told_what_is_read() {
    for name in ["frame.obj", "FRAME.OBJ", "bars.csv"] {
        let told = from_json::<serde_json::Value>(name, 0, b"v 0 0 0\n").unwrap_err();
        let says =
            "error: this is not JSON; a scene is TOML, and its `lattice.file` names a JSON file";
        assert!(told.to_string().starts_with(says), "{told}");
    }
}

#[test]
fn a_decimal_comma_becomes_a_point() {
    for (text, number) in [
        ("9,81", "9.81"),
        ("\"-1,5e-3\"", "-1.5e-3"),
        (" 0,6 ", "0.6"),
    ] {
        assert_eq!(with_decimal_point(text).as_deref(), Some(number));
    }
    for text in ["9.81", "1,2,3", "a,b", "1,", ",5", "[1,5]", ""] {
        assert_eq!(with_decimal_point(text), None, "{text}");
    }
}

#[test]
fn errors_point_at_the_keys_that_they_name() {
    let text = "{\"a\": 1,\n \"b\": {\"z\": [[0, 1],\n  [2]]}}";
    let placed = |message: &str| placed("a.json", text, Error::Usage(message.to_owned()));
    let told = |message: &str| placed(message).to_string();
    assert_eq!(
        told("a.json: `a` is 1, not `b`"),
        "error: `a` is 1, not `b`\n --> a.json:1:7"
    );
    assert!(told("length of `b.z`: 2").ends_with("--> a.json:2:13"));
    assert!(told("length of `b.z[1]`: 1").ends_with("--> a.json:3:3"));
    assert!(told("`b.z[0][1]` is 1").ends_with("--> a.json:2:18"));
    for unknown in [
        "no keys", "`c`", "`a.b`", "`b[0]`", "`b.z[2]`", "`b.z[x]`", "`",
    ] {
        assert!(matches!(placed(unknown), Error::Usage(same) if same == unknown));
    }
}

#[cfg(unix)]
#[test]
fn endless_files_are_refused() {
    let endless = read_whole("/dev/zero".as_ref()).unwrap_err();
    assert_eq!(endless.exit_code(), 2);
}
