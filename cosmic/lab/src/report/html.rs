//! The frame of every page: a single file of HTML that fetches nothing.

use crate::table::escape;

/// A whole page of HTML.
pub(super) fn page(title: &str, body: &str) -> String {
    let title = escape(title);
    let style = concat!(
        include_str!("page/theme.css"),
        include_str!("page/page.css")
    );
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         script-src 'unsafe-inline'; style-src 'unsafe-inline'\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )
}
