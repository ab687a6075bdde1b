"""Pages for people: `report.html` of a build."""
