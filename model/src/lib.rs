//! What both engines of stosszahl share: scene, state, collision law, domain, random streams, snapshots.
