"""HTTP to an Onshape server: authentication, counting of calls, retries within limits."""
