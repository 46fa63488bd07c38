//! The part of Rust's syntax that these tests read.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use syn::UseTree;

/// The tokens of a text without what is compiled for tests only.
pub(crate) fn code(text: &str) -> TokenStream {
    without_tests(text.parse().expect("Rust"))
}

fn without_tests(tokens: TokenStream) -> TokenStream {
    let (mut kept, mut is_test) = (Vec::new(), false);
    for token in tokens {
        let is_body = |group: &Group| group.delimiter() == Delimiter::Brace;
        let ends = is(&token, ';') || group(&token).is_some_and(is_body);
        match group(&token) {
            _ if is_test => is_test = !ends,
            Some(mark) if mark.stream().to_string() == "cfg (test)" => {
                // With the `#` before it, and the attributes before that.
                kept.pop();
                while let [.., hash, TokenTree::Group(_)] = &kept[..]
                    && is(hash, '#')
                {
                    kept.truncate(kept.len() - 2);
                }
                is_test = true;
            }
            Some(group) => {
                let inside = without_tests(group.stream());
                kept.push(Group::new(group.delimiter(), inside).into());
            }
            None => kept.push(token),
        }
    }
    kept.into_iter().collect()
}

fn is(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(mark) if mark.as_char() == character)
}

fn group(token: &TokenTree) -> Option<&Group> {
    match token {
        TokenTree::Group(group) => Some(group),
        _ => None,
    }
}

/// A path that a module names.
#[derive(Debug)]
pub(crate) struct Named {
    /// The module, which may be one that is written inside of a file.
    pub(crate) module: Vec<String>,
    pub(crate) path: Vec<String>,
    pub(crate) how: How,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum How {
    /// By a `use` that passes it on.
    PassedOn,
    /// By another `use`.
    Imported,
    /// Anywhere else, a macro too.
    Inline,
}

/// Every path in a module's code.
pub(crate) fn named(module: &[String], code: TokenStream) -> Vec<Named> {
    let tokens: Vec<TokenTree> = code.into_iter().collect();
    let mut all = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let (paths, how, length) = match &tokens[at..] {
            [TokenTree::Ident(word), tree @ ..] if word == "use" => {
                let end = tree.iter().position(|token| is(token, ';'));
                let end = end.unwrap_or(tree.len());
                // What a macro imports may be no tree.
                let tree = syn::parse2(tree[..end].iter().cloned().collect());
                let paths = tree.map_or(Vec::new(), |tree| leaves(&[], &tree));
                (paths, how(&tokens[..at]), 1 + end)
            }
            [TokenTree::Ident(word), TokenTree::Ident(name), body, ..]
                if word == "mod" && group(body).is_some() =>
            {
                let inner = [module, &[name.to_string()]].concat();
                let body = group(body).map(Group::stream).unwrap_or_default();
                all.extend(named(&inner, body));
                (Vec::new(), How::Inline, 3)
            }
            // A path from the crate that uses the macro.
            [mark, TokenTree::Ident(_), ..] if is(mark, '$') => (Vec::new(), How::Inline, 2),
            rest => {
                let inside = group(&rest[0]).map(Group::stream).unwrap_or_default();
                all.extend(named(module, inside));
                let path = path(rest);
                let length = (3 * path.len()).max(3) - 2;
                let paths = Some(path).filter(|path| path.len() > 1);
                (Vec::from_iter(paths), How::Inline, length)
            }
        };
        all.extend(paths.into_iter().map(|path| Named {
            module: module.to_vec(),
            path,
            how,
        }));
        at += length;
    }
    all
}

/// How a `use` names its paths, by the tokens before it.
fn how(before: &[TokenTree]) -> How {
    match before {
        [.., TokenTree::Ident(word)] if word == "pub" => How::PassedOn,
        [.., TokenTree::Ident(word), TokenTree::Group(_)] if word == "pub" => How::PassedOn,
        _ => How::Imported,
    }
}

/// The names with `::` between them that begin here.
fn path(mut tokens: &[TokenTree]) -> Vec<String> {
    let mut names = Vec::new();
    while let [TokenTree::Ident(name), rest @ ..] = tokens {
        names.push(name.to_string());
        tokens = match rest {
            [first, second, rest @ ..] if is(first, ':') && is(second, ':') => rest,
            _ => break,
        };
    }
    names
}

/// The paths of a tree of imports.
pub(crate) fn leaves(stem: &[String], tree: &UseTree) -> Vec<Vec<String>> {
    let with = |name: &dyn ToString| [stem, &[name.to_string()]].concat();
    match tree {
        UseTree::Path(path) => leaves(&with(&path.ident), &path.tree),
        UseTree::Group(group) => {
            let trees = group.items.iter();
            trees.flat_map(|tree| leaves(stem, tree)).collect()
        }
        UseTree::Name(name) => vec![with(&name.ident)],
        UseTree::Rename(name) => vec![with(&name.ident)],
        UseTree::Glob(_) => vec![with(&'*')],
    }
}
