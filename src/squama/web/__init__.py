"""The explorer: one page in the browser on which a beam is turned, changed, loaded and compared (extra ``web``)."""
