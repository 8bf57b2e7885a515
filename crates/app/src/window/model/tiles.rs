//! How the panes of a document lie beside each other.

use super::document::Document;
use super::pane_id::PaneId;
use super::pane_tree::PaneTree;
use eframe::egui::Id;
use egui_tiles::{Tile, Tiles};

/// An even arrangement of the document's panes.
fn even(document: &Document) -> PaneTree {
    let ids: Vec<PaneId> = document.panes.iter().map(|p| p.id).collect();
    match ids[..] {
        [] | [_] | [_, _] => PaneTree::new_horizontal(Id::unique("panes"), ids),
        // A grid would leave a place empty: one large and two beside it; two above three.
        [first, second, third] => {
            let mut tiles = Tiles::default();
            let [a, b, c] = [first, second, third].map(|id| tiles.insert_pane(id));
            let right = tiles.insert_vertical_tile(vec![b, c]);
            let root = tiles.insert_horizontal_tile(vec![a, right]);
            PaneTree::new(Id::unique("panes"), root, tiles)
        }
        [a, b, c, d, e] => {
            let mut tiles = Tiles::default();
            let [a, b, c, d, e] = [a, b, c, d, e].map(|id| tiles.insert_pane(id));
            let upper = tiles.insert_horizontal_tile(vec![a, b]);
            let lower = tiles.insert_horizontal_tile(vec![c, d, e]);
            let root = tiles.insert_vertical_tile(vec![upper, lower]);
            PaneTree::new(Id::unique("panes"), root, tiles)
        }
        _ => PaneTree::new_grid(Id::unique("panes"), ids),
    }
}

/// The document's tiles if they hold exactly its panes, else an even arrangement.
pub fn tree_of(document: &Document) -> PaneTree {
    let Some(tree) = &document.tiles else { return even(document) };
    let mut held: Vec<PaneId> = tree.tiles.tiles().filter_map(pane_of).collect();
    let mut wanted: Vec<PaneId> = document.panes.iter().map(|p| p.id).collect();
    held.sort();
    wanted.sort();
    if held == wanted && tree.root().is_some() { tree.clone() } else { even(document) }
}

/// The pane in a tile.
fn pane_of(tile: &Tile<PaneId>) -> Option<PaneId> {
    match tile {
        Tile::Pane(id) => Some(*id),
        Tile::Container(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::document::MAX_PANES;
    use super::super::method::MethodChoice;
    use super::*;
    use egui_tiles::Container;

    #[test]
    fn every_number_of_panes_fills_the_window() {
        for count in 1..=MAX_PANES {
            let document = Document::of_methods((0..count).map(|_| MethodChoice::new("pinhole")));
            let tree = tree_of(&document);
            let mut held: Vec<PaneId> = tree.tiles.tiles().filter_map(pane_of).collect();
            held.sort();
            assert_eq!(held, document.panes.iter().map(|pane| pane.id).collect::<Vec<_>>());
            // Only a grid has places that nothing stands in; with four and six it has none.
            let has_grid = tree.tiles.tiles().any(|tile| matches!(tile, Tile::Container(Container::Grid(_))));
            assert_eq!(has_grid, [4, 6].contains(&count), "{count} panes");
        }
    }
}
