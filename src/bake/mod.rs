//! Offline: mesh → basis → cubature → one baked avatar.
