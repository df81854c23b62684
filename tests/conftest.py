"""Settings of hypothesis: the same examples in every run, no clock, no files left behind."""

from hypothesis import HealthCheck, Phase, settings

settings.register_profile(
    "squama",
    derandomize=True,
    deadline=None,
    max_examples=60,
    print_blob=False,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("mutants", settings.get_profile("squama"), phases=(Phase.explicit, Phase.generate))
settings.load_profile("squama")
