"""The explorer: a web page on which a beam is changed, loaded, viewed and compared (extra ``web``)."""
