"""An assembly of an Onshape server, or the replies recorded of one, as a bundle.

- call_budget: The call budget: how many API calls a build may make (`source.max_calls`).
- configuration: The configuration of an assembly: checks the user's values and encodes them as Onshape does.
- configured: Chooses the configuration to build: that of the address, overridden by the user's values.
- definition: Reads from an assembly definition which assembly it is and which part studios it needs.
- gather: From an assembly to its bundle: definition, then the part studios, then their replies.
- reply_sizes: Size limits of replies, by kind [bytes, decompressed].
- requests: The requests that a build makes, in one canonical form.
- section: Configuration of the source `onshape`.
- source: The source `onshape`: an assembly in an Onshape document.
- url: The address of an assembly, as the browser shows it.
"""
