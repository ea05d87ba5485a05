"""Generated meshes and independent reference implementations for the tests."""
