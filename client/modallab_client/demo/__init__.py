"""The lab's main job from end to end, over HTTP; run by `modallab demo`."""
