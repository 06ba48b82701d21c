//! Reads the data files of ADBench as inputs of GradBench.

use std::path::Path;
use std::str::FromStr;

use serde_json::{Value, json};

use crate::objectives::Error;

/// The tokens of a file, which are separated by white space or colons.
struct Tokens<'a> {
    rest: std::vec::IntoIter<&'a str>,
    all: usize,
}

/// The value that was read, or a description of what is wrong with the file.
type Read<T> = Result<T, String>;

impl Tokens<'_> {
    fn next<T: FromStr>(&mut self) -> Read<T> {
        let place = self.all - self.rest.len() + 1;
        let token = self.rest.next();
        let token =
            token.ok_or_else(|| format!("the file ends too early: token {place} is missing"))?;
        let number = token.parse();
        number.map_err(|_| format!("token {place} cannot be read: '{token}'"))
    }

    /// Reads the next token as a count of at least one. Counts are limited, so that a damaged file does not use up all
    /// memory.
    fn count(&mut self) -> Read<usize> {
        const MOST: usize = 1 << 24;
        let count = self.next()?;
        let fits = (1..=MOST).contains(&count);
        fits.then_some(count)
            .ok_or_else(|| format!("the count is {count}; it must be from 1 to {MOST}"))
    }

    fn list<T: FromStr>(&mut self, len: usize) -> Read<Vec<T>> {
        (0..len).map(|_| self.next()).collect()
    }

    fn rows(&mut self, rows: usize, columns: usize) -> Read<Vec<Vec<f64>>> {
        (0..rows).map(|_| self.list(columns)).collect()
    }
}

/// Reads a whole file. `content` converts the tokens of the file to the result.
fn read<T>(path: &Path, content: impl FnOnce(&mut Tokens) -> Read<T>) -> Result<T, Error> {
    let wrong = Error::file(path);
    let text = Error::read(path)?;
    let tokens = text.split(|c: char| c == ':' || c.is_whitespace());
    let tokens: Vec<&str> = tokens.filter(|token| !token.is_empty()).collect();
    let mut tokens = Tokens {
        all: tokens.len(),
        rest: tokens.into_iter(),
    };
    let value = content(&mut tokens).map_err(&wrong)?;
    match tokens.rest.next() {
        None => Ok(value),
        Some(token) => Err(wrong(format!("unexpected token after the end: '{token}'"))),
    }
}

/// Reads the data file of a problem as the GradBench input of the module `gmm`, `ba`, `lstm` or `ht`. For `ht`, the
/// folder `model` contains the model of the hand.
///
/// # Errors
/// If the module is unknown, or a file cannot be read or has the wrong format.
pub fn input(module: &str, file: &Path, model: &Path) -> Result<Value, Error> {
    match module {
        "gmm" => read(file, gmm),
        "ba" => read(file, ba),
        "lstm" => read(file, lstm),
        "ht" => read(file, |tokens| hand(tokens, hand_model(model))),
        _ => Err(Error::Unknown(format!("problem '{module}'"))),
    }
}

fn gmm(tokens: &mut Tokens) -> Read<Value> {
    let (d, k, n) = (tokens.count()?, tokens.count()?, tokens.count()?);
    let (alpha, mu) = (tokens.list(k)?, tokens.rows(k, d)?);
    let factor = |_| Ok((tokens.list(d)?, tokens.list(d * (d - 1) / 2)?));
    let factors: Read<Vec<(Vec<f64>, Vec<f64>)>> = (0..k).map(factor).collect();
    let (q, l): (Vec<_>, Vec<_>) = factors?.into_iter().unzip();
    let (x, gamma, m) = (tokens.rows(n, d)?, tokens.next()?, tokens.next()?);
    let (alpha, gamma, m): (Vec<f64>, f64, u32) = (alpha, gamma, m);
    Ok(json!({
        "d": d, "k": k, "n": n, "x": x, "m": m, "gamma": gamma,
        "alpha": alpha, "mu": mu, "q": q, "l": l, "sign": -1.0,
    }))
}

fn ba(tokens: &mut Tokens) -> Read<Value> {
    let (n, m, p) = (tokens.count()?, tokens.count()?, tokens.count()?);
    let (cam, x) = (tokens.list::<f64>(11)?, tokens.list::<f64>(3)?);
    let (w, feat) = (tokens.next::<f64>()?, tokens.list::<f64>(2)?);
    Ok(json!({ "n": n, "m": m, "p": p, "cam": cam, "x": x, "w": w, "feat": feat }))
}

fn lstm(tokens: &mut Tokens) -> Read<Value> {
    let (layers, characters, bits) = (tokens.count()?, tokens.count()?, tokens.count()?);
    Ok(json!({
        "main_params": tokens.rows(2 * layers, 4 * bits)?,
        "extra_params": tokens.rows(3, bits)?,
        "state": tokens.rows(2 * layers, bits)?,
        "sequence": tokens.rows(characters, bits)?,
    }))
}

/// Reads a problem of hand tracking. The problem is a complicated one if the file has `u1 u2` for each correspondence.
fn hand(tokens: &mut Tokens, model: Result<Value, Error>) -> Read<Value> {
    let (count, theta) = (tokens.count()?, tokens.count()?);
    let complicated = tokens.all == 2 + 6 * count + theta;
    let target = |_| Ok((tokens.next()?, tokens.list(3)?));
    let targets: Read<Vec<(usize, Vec<f64>)>> = (0..count).map(target).collect();
    let (correspondences, points): (Vec<_>, Vec<_>) = targets?.into_iter().unzip();
    let us = tokens.rows(if complicated { count } else { 0 }, 2)?;
    let model = model.map_err(|error| error.to_string())?;
    Ok(json!({
        "us": us,
        "theta": tokens.list::<f64>(theta)?,
        "data": { "model": model, "correspondences": correspondences, "points": points },
    }))
}

/// Reads the three files of a hand model.
fn hand_model(folder: &Path) -> Result<Value, Error> {
    let (mut names, mut parents) = (Vec::<String>::new(), Vec::<i64>::new());
    let (mut relatives, mut inverses) = (Vec::new(), Vec::new());
    read(&folder.join("bones.txt"), |tokens| {
        while tokens.rest.len() > 0 {
            names.push(tokens.next()?);
            parents.push(tokens.next()?);
            relatives.push(tokens.rows(4, 4)?);
            inverses.push(tokens.rows(4, 4)?);
        }
        Ok(())
    })?;
    let (mut positions, mut all_weights) = (Vec::new(), Vec::new());
    read(&folder.join("vertices.txt"), |tokens| {
        while tokens.rest.len() > 0 {
            let numbers = tokens.list::<f64>(8)?;
            let mut weights = vec![0.0; names.len()];
            for _ in 0..tokens.next::<usize>()? {
                let (bone, weight) = (tokens.next::<usize>()?, tokens.next()?);
                let unknown = || format!("unknown bone {bone}");
                *weights.get_mut(bone).ok_or_else(unknown)? = weight;
            }
            positions.push([&numbers[..3], &[1.0]].concat());
            all_weights.push(weights);
        }
        Ok(())
    })?;
    let triangles = read(&folder.join("triangles.txt"), |tokens| {
        let all = tokens.list::<usize>(tokens.all)?;
        Ok(all.chunks(3).map(Vec::from).collect::<Vec<_>>())
    })?;
    Ok(json!({
        "bone_count": names.len(), "bone_names": names, "parents": parents,
        "base_relatives": relatives, "inverse_base_absolutes": inverses,
        "base_positions": positions, "weights": all_weights,
        "triangles": triangles, "is_mirrored": false,
    }))
}
