def run(options, cache, pool, display): pass
