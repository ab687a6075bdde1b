"""Asking a server: which calls a build makes, and in which order.

- cached_client: Cached replies first, then the server: each reply is billed once, also among several
  processes.
- freshness: Finds whether a workspace changed since its last build, and which of its tabs did.
- limits: Fetches limits that the definition lacks from an Onshape server.
- live: Replies from an Onshape server, in as few calls as the changes to the assembly allow.
- online: Fetches from the server: sets variables first; uses the last complete fetch where the quota is used
  up.
- session: Connection to the server of one assembly: opened for the first call; checks the replies.
- triangle_refusals: How often tessellated faces were refused whose glTF is kept: once may be a fault that
  passes, twice lasts.
- triangle_requests: Requests the triangles of a part studio: tessellated faces, or glTF where the server
  refuses them.
- variables: Sets variables of a document for one build.
"""
