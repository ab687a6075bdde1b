"""HTTP to an Onshape server: authentication, counting of calls, retries within limits.

- call: Defines an API call: method, request, body and headers.
- client: Calls the Onshape API over HTTP: authenticates, counts and retries calls, a few at a time.
- connection_errors: Explains errors of the connection (DNS, TCP, proxy, TLS certificate), each with a hint.
- credentials: Finds the user's Onshape credentials: in the environment, or in `.env` in the working folder.
- decompression: Decompresses the body of a reply piece by piece, so that its reader may stop at a size limit.
- halt: Stops all calls of a client: after a stop no call begins.
- http_errors: Makes the errors for HTTP status codes and unusable replies, each with a hint.
- ledger: Counts the calls made and billed, by key and calendar year: a count that Onshape itself does not
  give.
- network_settings: Checks the environment variables of the network: proxies and trusted certificates.
- rate_limits: Tracks the server's rate limits: the calls left of each kind, and the wait if none is left.
- received: Shows the progress of long downloads a few times a second.
- redirects: Follows redirects by hand, so that a key is sent only to hosts of its owner.
- retries: Defines retries: the temporary failures, the numbers of attempts, and the waits between them.
- signing: Authenticates a request: Basic, signed with the secret key, or by a bearer token.
- threads: Makes a few calls at a time, in threads that never keep the process alive.
- transport: Sends an HTTP request and returns its complete reply, and is the only module that imports httpx.
"""
