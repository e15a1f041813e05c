from hypothesis import settings

# What is imported at its first use may take longer than hypothesis allows an example; no test is timed here.
current = settings.get_profile(settings.get_current_profile_name())
settings.register_profile("untimed", parent=current, deadline=None)
settings.load_profile("untimed")
