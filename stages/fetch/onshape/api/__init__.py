"""HTTP to an Onshape server: authentication, counting of calls, retries within limits.

- call: One API call: method, request, body and headers.
- client: The HTTP client of the Onshape API: authenticates, counts and retries calls, a few at a time.
- connection_errors: Errors of the connection (DNS, TCP, proxy, TLS certificate), each with a hint.
- credentials: The user's Onshape credentials: from the environment, or from `.env` in the working folder.
- decompression: Decompresses the body of a reply piece by piece, so that its reader may stop at a size limit.
- halt: Stops all calls of one client: after a stop no call begins.
- http_errors: Errors for HTTP status codes and unusable replies, each with a hint.
- ledger: Calls made and billed, by key and calendar year: a count that Onshape itself does not give.
- network_settings: The environment variables of the network: proxies and trusted certificates.
- rate_limits: The server's rate limits: how many calls of each kind are left, and waiting where none is left.
- received: Shows the progress of long downloads a few times a second.
- redirects: Follows redirects by hand, so that a key is sent only to hosts of its owner.
- retries: Retries: which failures are temporary, how often to try, and how long to wait in between.
- signing: Authentication of a request: Basic, signed with the secret key, or by a bearer token.
- threads: A few calls at a time, in threads that never keep the process alive.
- transport: Sends one HTTP request and returns its complete reply.
"""
