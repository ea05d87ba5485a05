"""What the tests share: generated meshes and independent reference implementations."""
