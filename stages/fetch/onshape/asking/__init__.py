"""Asks a server: the calls that a build makes, and their order.

- ahead: Counts the calls that a fetch will make, once the definition of its assembly is known.
- cached_client: Answers requests from cached replies first, then from the server: each reply is billed once,
  also among several processes.
- freshness: Finds whether a workspace changed since its last build, and the tabs that changed.
- limits: Fetches limits that the definition lacks from an Onshape server.
- live: Gets replies from an Onshape server, in as few calls as the changes to the assembly allow.
- mechanism: Gets only the replies that describe the mechanism of an assembly: its definition, and perhaps the
  masses of its parts.
- online: Fetches from the server: sets variables first; uses the last complete fetch if the quota is used up.
- session: Connects to the server of an assembly for the first call, and checks the replies.
- triangle_refusals: Counts the refusals of tessellated faces whose glTF is cached.
- triangle_requests: Requests the triangles of a part studio: tessellated faces, or glTF if the server refuses
  them.
- variables: Sets variables of a document for a build, which writes to the user's CAD and is undone at once.
"""
