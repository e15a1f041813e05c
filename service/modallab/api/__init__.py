"""HTTP service: routes, request models, replies, problems and the OpenAPI document."""
