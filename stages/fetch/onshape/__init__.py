"""Makes a bundle of an assembly of an Onshape server, or of the replies recorded of an assembly.

- call_budget: Limits the number of API calls that a build, or a whole sweep, may make (`source.max_calls`).
- configuration: Checks the user's values of an assembly's configuration and encodes them as Onshape does.
- configured: Chooses the configuration to build: that of the address, overridden by the user's values.
- definition: Reads the identity of an assembly and its part studios from the assembly definition.
- gather: Makes the bundle of an assembly: definition, then the part studios, then their replies.
- reply_sizes: Lists the size limits of replies, by kind [bytes, decompressed].
- requests: Writes the requests that a build makes, in their canonical form.
- section: Configuration of the source `onshape`.
- source: Defines the source `onshape`: an assembly in an Onshape document.
- url: Parses the address of an assembly, as the browser shows it.
"""
