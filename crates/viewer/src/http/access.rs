//! Access control for the page and its API.
//!
//! Other web sites that are open in the same browser as the page can send requests to this server.
//! Other web sites cannot read the responses, since the server sends no CORS headers. The checks in
//! this module reject requests from other web sites and prevent DNS rebinding.

use std::io;
use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::http::jobs::{ApiError, ApiResult};
use crate::http::shares::Connection;

/// The content security policy, which restricts the page to resources from this server.
const CONTENT_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' blob: data:; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";

const SEC_FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");
const SEC_FETCH_DEST: HeaderName = HeaderName::from_static("sec-fetch-dest");

/// The access rules of a server.
#[derive(Debug)]
pub(crate) struct Access {
    /// The token that every request must contain, or `None` if only this machine can reach the
    /// server.
    token: Option<String>,
    /// The name of the cookie that contains the token. The cookie name includes the port, since
    /// browsers share cookies between all ports of a host.
    cookie_name: String,
}

impl Access {
    pub(crate) fn new(token: Option<String>, port: u16) -> Self {
        Self { token, cookie_name: format!("mmsim-{port}") }
    }

    /// Returns the part of the page's URL after the port. This part contains the token, or is empty
    /// if there is no token.
    pub(crate) fn query(&self) -> String {
        self.token.as_ref().map(|token| format!("/?token={token}")).unwrap_or_default()
    }

    fn check(&self, method: &Method, uri: &Uri, headers: &HeaderMap) -> ApiResult<()> {
        let host = self.check_host(uri, headers)?;
        Self::check_site(method, uri, headers, &host)?;
        match &self.token {
            Some(token) if !self.has_token(token, uri, headers) => Err(ApiError::new(
                StatusCode::UNAUTHORIZED,
                "the token is missing or wrong (open the URL that mmsim printed at startup)",
            )),
            _ => Ok(()),
        }
    }

    /// Returns the host of a request, or an error if the host is not allowed. Without a token, only
    /// hosts that always refer to this machine are allowed. With a token, every host is allowed,
    /// since a browser sends the cookie only to the host that set it.
    fn check_host(&self, uri: &Uri, headers: &HeaderMap) -> ApiResult<String> {
        let mut hosts = headers.get_all(header::HOST).iter();
        let host = match (hosts.next(), hosts.next(), uri.authority()) {
            (Some(host), None, None) => host.to_str().unwrap_or_default().to_ascii_lowercase(),
            (host, _, authority) => {
                let text = format!(
                    "expected one Host header and a request target without a host, found {host:?} \
                     and {authority:?}"
                );
                return Err(ApiError::bad_request(text));
            }
        };
        if self.token.is_some() || is_loopback(&host) {
            return Ok(host);
        }
        let text = format!("the host {host:?} is not allowed (use localhost or 127.0.0.1)");
        Err(ApiError::new(StatusCode::FORBIDDEN, text))
    }

    /// Rejects requests from other web sites, based on the headers that browsers set.
    fn check_site(method: &Method, uri: &Uri, headers: &HeaderMap, host: &str) -> ApiResult<()> {
        let forbidden = |text: &str| Err(ApiError::new(StatusCode::FORBIDDEN, text));
        let origin = headers.get(header::ORIGIN).map(|origin| origin.to_str().unwrap_or("?"));
        match origin {
            Some(origin) if !is_origin_of(origin, host) => {
                return forbidden(&format!("requests from the origin {origin:?} are not allowed"));
            }
            // Every browser sends the origin with requests that may change state.
            None if *method != Method::GET && *method != Method::HEAD => {
                return forbidden("the Origin header is missing");
            }
            _ => {}
        }
        let header = |name| headers.get(name).map(|value: &HeaderValue| value.as_bytes());
        match header(SEC_FETCH_SITE) {
            None | Some(b"same-origin" | b"none") => Ok(()),
            // The user followed a link to the page.
            Some(_) if uri.path() == "/" && header(SEC_FETCH_DEST) == Some(b"document") => Ok(()),
            Some(_) => forbidden("requests from other web sites are not allowed"),
        }
    }

    fn has_token(&self, token: &str, uri: &Uri, headers: &HeaderMap) -> bool {
        let tokens = cookies(headers, &self.cookie_name);
        tokens.chain(query_token(uri)).any(|sent| constant_time_eq(sent, token))
    }

    /// Returns the name of the cookie that tells browsers at the same address apart.
    fn browser_cookie_name(&self) -> String {
        format!("{}-browser", self.cookie_name)
    }

    /// Returns a new cookie for a browser, or `None` if there are no random numbers.
    fn browser_cookie(&self) -> Option<HeaderValue> {
        let (name, browser) = (self.browser_cookie_name(), random_digits().ok()?);
        let cookie = format!("{name}={browser}; Path=/; HttpOnly; SameSite=Strict");
        HeaderValue::from_str(&cookie).ok()
    }

    /// Returns a cookie with the server's token if the URL of a request contains a token.
    fn cookie_for(&self, uri: &Uri) -> Option<HeaderValue> {
        let (token, _) = (self.token.as_ref()?, query_token(uri)?);
        let cookie = format!("{}={token}; Path=/; HttpOnly; SameSite=Lax", self.cookie_name);
        HeaderValue::from_str(&cookie).ok()
    }
}

/// Rejects unauthorized requests and sets the security headers of every response.
pub(crate) async fn guard(
    State(access): State<Arc<Access>>,
    request: Request,
    next: Next,
) -> Response {
    let checked = access.check(request.method(), request.uri(), request.headers());
    let browser = cookies(request.headers(), &access.browser_cookie_name()).next();
    if let (Ok(()), Some(browser), Some(connection)) =
        (&checked, browser, request.extensions().get::<Arc<Connection>>())
    {
        connection.set_browser(browser);
    }
    let new_browser = browser.is_none() && request.uri().path() == "/";
    let browser_cookie = if new_browser { access.browser_cookie() } else { None };
    let mut response = match (checked, access.cookie_for(request.uri())) {
        // Removes the token from the address bar, where others could read it.
        (Ok(()), Some(cookie)) if request.uri().path() == "/" => {
            let headers =
                [(header::LOCATION, HeaderValue::from_static("/")), (header::SET_COOKIE, cookie)];
            (StatusCode::SEE_OTHER, headers).into_response()
        }
        (Ok(()), _) => next.run(request).await,
        (Err(error), _) => error.into_response(),
    };
    let headers = response.headers_mut();
    if let Some(cookie) = browser_cookie {
        headers.append(header::SET_COOKIE, cookie);
    }
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, CONTENT_POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // With a token, the host is usually not a loopback host. For other hosts, browsers ignore this
    // header and log a warning unless the connection is encrypted.
    if access.token.is_none() {
        let name = HeaderName::from_static("cross-origin-opener-policy");
        headers.insert(name, HeaderValue::from_static("same-origin"));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

/// Returns true if a host, with or without a port, always refers to this machine, regardless of
/// DNS.
fn is_loopback(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let address = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name == "localhost"
        || address.parse().is_ok_and(|address: IpAddr| address.to_canonical().is_loopback())
}

fn is_origin_of(origin: &str, host: &str) -> bool {
    let rest = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    rest.is_some_and(|rest| rest.eq_ignore_ascii_case(host))
}

/// Returns the values of the cookies with this name.
fn cookies<'h>(headers: &'h HeaderMap, name: &str) -> impl Iterator<Item = &'h str> {
    let cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    cookies.flat_map(|cookies| cookies.split(';')).filter_map(move |cookie| {
        let (found, value) = cookie.trim().split_once('=')?;
        (found == name).then_some(value)
    })
}

/// Returns 128 random bits as hexadecimal digits.
pub(crate) fn random_digits() -> io::Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    let digits = |byte: u8| format!("{byte:02x}");
    Ok(bytes.into_iter().map(digits).collect())
}

fn query_token(uri: &Uri) -> Option<&str> {
    uri.query()?.split('&').find_map(|pair| pair.strip_prefix("token="))
}

/// Compares two strings in a time that depends only on their lengths. The time therefore does not
/// reveal how much of a guessed token is correct.
fn constant_time_eq(sent: &str, token: &str) -> bool {
    let differing = sent.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    sent.len() == token.len() && differing == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(access: &Access, method: &Method, uri: &str, headers: &[(&str, &str)]) -> u16 {
        let headers = headers
            .iter()
            .map(|(name, value)| (name.parse::<HeaderName>().unwrap(), value.parse().unwrap()))
            .fold(HeaderMap::new(), |mut headers, (name, value)| {
                headers.append(name, value);
                headers
            });
        let checked = access.check(method, &uri.parse().unwrap(), &headers);
        checked.map_or_else(|error| error.status.as_u16(), |()| 200)
    }

    const HOST: (&str, &str) = ("host", "127.0.0.1:6575");

    #[test]
    fn only_loopback_hosts_are_accepted() {
        let access = Access::new(None, 6575);
        let get = |host| check(&access, &Method::GET, "/", &[("host", host)]);
        for host in [
            "127.0.0.1:6575",
            "localhost:6575",
            "LOCALHOST",
            "[::1]:6575",
            "127.0.0.2",
            "localhost:8080",
        ] {
            assert_eq!(get(host), 200, "{host}");
        }
        for host in [
            "",
            "evil.example:6575",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "192.168.1.7:6575",
            "localhost:evil.example",
            "0x7f.1",
            "[::1",
        ] {
            assert_eq!(get(host), 403, "{host}");
        }
        assert_eq!(check(&access, &Method::GET, "/", &[]), 400);
        assert_eq!(check(&access, &Method::GET, "/", &[HOST, HOST]), 400);
        assert_eq!(check(&access, &Method::GET, "http://evil.example/", &[HOST]), 400);
    }

    #[test]
    fn requests_of_other_sites_are_rejected() {
        let access = Access::new(None, 6575);
        let ask = |method: &Method, path, name, value| {
            check(&access, method, path, &[HOST, (name, value)])
        };
        for method in [Method::GET, Method::POST] {
            assert_eq!(ask(&method, "/api/maze", "origin", "http://127.0.0.1:6575"), 200);
            for origin in [
                "http://evil.example",
                "http://127.0.0.1:3000",
                "http://localhost:6575",
                "null",
                "",
                "file://",
            ] {
                assert_eq!(ask(&method, "/api/maze", "origin", origin), 403, "{origin}");
            }
        }
        assert_eq!(check(&access, &Method::POST, "/api/maze", &[HOST]), 403, "no origin");
        assert_eq!(check(&access, &Method::GET, "/api/mazes", &[HOST]), 200);
        for (site, status) in
            [("same-origin", 200), ("none", 200), ("same-site", 403), ("cross-site", 403)]
        {
            assert_eq!(ask(&Method::GET, "/api/mazes", "sec-fetch-site", site), status);
        }
        let follow = |dest| {
            let headers = [HOST, ("sec-fetch-site", "cross-site"), ("sec-fetch-dest", dest)];
            check(&access, &Method::GET, "/", &headers)
        };
        assert_eq!((follow("document"), follow("iframe")), (200, 403));
    }

    #[test]
    fn the_token_is_required() {
        let access = Access::new(Some("secret".into()), 6575);
        let get = |uri, headers: &[(&str, &str)]| {
            check(&access, &Method::GET, uri, &[&[("host", "mouse.lan:6575")], headers].concat())
        };
        assert_eq!(get("/", &[]), 401);
        assert_eq!(get("/?token=secret", &[]), 200);
        assert_eq!(get("/api/mazes?x=1&token=secret", &[]), 200);
        for uri in
            ["/?token=", "/?token=secre", "/?token=secret2", "/?token=Secret", "/?xtoken=secret"]
        {
            assert_eq!(get(uri, &[]), 401, "{uri}");
        }
        assert_eq!(get("/", &[("cookie", "a=b; mmsim-6575=secret")]), 200);
        assert_eq!(get("/", &[("cookie", "mmsim-6576=secret")]), 401);
        assert_eq!(
            get("/", &[("cookie", "mmsim-6575=secret"), ("origin", "http://evil.example")]),
            403
        );
        assert_eq!(access.query(), "/?token=secret");
        let cookie = access.cookie_for(&"/?token=secret".parse().unwrap()).unwrap();
        assert_eq!(cookie, "mmsim-6575=secret; Path=/; HttpOnly; SameSite=Lax");
    }
}
